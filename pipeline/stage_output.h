// SPDX-License-Identifier: BSD-3-Clause
// The folders of a stage. A running stage writes into STAGE.partial, a finished
// result is STAGE, and a result that is being replaced is STAGE.old. Whenever
// the program is killed, RecoverStage finds the last finished result complete,
// and the folder that can be continued.
//
//   STAGE.partial/partial.json   the fingerprint of the inputs and options
//   STAGE.partial/usage.json     time and memory that it took so far
//   STAGE.partial/stage.json     how the run ended, if it ended
//   STAGE/stage.json             the record of a run that ended well
//
// A result is replaced in four steps:
//   1. stage.json, with the outcome done, is written into STAGE.partial.
//   2. STAGE is renamed to STAGE.old.
//   3. STAGE.partial is renamed to STAGE.
//   4. STAGE.old is deleted.
// When the program is killed before step 1, STAGE is untouched and
// STAGE.partial can be continued. When it is killed later, the next start does
// the steps that are left.

#ifndef FREEGS_PIPELINE_STAGE_OUTPUT_H_
#define FREEGS_PIPELINE_STAGE_OUTPUT_H_

#include <filesystem>
#include <string>
#include <vector>

#include "core/status.h"
#include "pipeline/resource_usage.h"
#include "pipeline/stage_record.h"

namespace freegs::pipeline {

// Makes an empty STAGE.partial, and writes the fingerprint into it.
Status BeginPartial(const std::filesystem::path& partial,
                    const StageFingerprint& fingerprint);

// Prepares STAGE.partial for a run that continues it.
Status ContinuePartial(const std::filesystem::path& partial);

// Returns kBadInput if there is none or if it is malformed.
StatusOr<StageFingerprint> ReadPartialFingerprint(
    const std::filesystem::path& partial);

// The time and memory that earlier runs into STAGE.partial took; zeros if that
// is not known.
ResourceUsage ReadPartialUsage(const std::filesystem::path& partial);
Status WritePartialUsage(const std::filesystem::path& partial,
                         const ResourceUsage& usage);

// The sorted names of the files and folders in STAGE.partial or STAGE that the
// stage itself has made.
std::vector<std::string> StageContents(const std::filesystem::path& folder);

// Steps 1 to 4 above.
Status FinishPartial(const std::filesystem::path& workspace,
                     const std::string& stage,
                     const StageRecord& record);

// Does the steps that a killed program left undone.
Status RecoverStage(const std::filesystem::path& workspace,
                    const std::string& stage);

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_STAGE_OUTPUT_H_
