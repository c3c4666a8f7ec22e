// SPDX-License-Identifier: BSD-3-Clause
// The folders of a stage: begun as STAGE.partial, finished as STAGE, replaced
// by way of STAGE.old. Whenever the program is killed, RecoverStage finds the
// last finished result whole and what can be continued.
//
//   STAGE.partial/partial.json   what the output is being made from
//   STAGE.partial/usage.json     time and memory it took so far
//   STAGE.partial/stage.json     how the run ended, if it did
//   STAGE/stage.json             always of outcome done
//
// Replacing: 1. stage.json (done) is written into STAGE.partial as its last
// file, 2. STAGE -> STAGE.old, 3. STAGE.partial -> STAGE, 4. STAGE.old is
// deleted. Killed before 1: STAGE stands and STAGE.partial can be continued.
// Killed later: the remaining steps are done at the next start.

#ifndef FREEGS_PIPELINE_STAGE_OUTPUT_H_
#define FREEGS_PIPELINE_STAGE_OUTPUT_H_

#include <filesystem>
#include <string>

#include "core/status.h"
#include "pipeline/resource_usage.h"
#include "pipeline/stage_record.h"

namespace freegs::pipeline {

// Makes an empty STAGE.partial for the given fingerprint.
Status BeginPartial(const std::filesystem::path& partial,
                    const StageFingerprint& fingerprint);

// Makes STAGE.partial ready to be continued.
Status ContinuePartial(const std::filesystem::path& partial);

// kBadInput if there is none or it is malformed.
StatusOr<StageFingerprint> ReadPartialFingerprint(
    const std::filesystem::path& partial);

// What earlier runs into STAGE.partial took; zeros if unknown.
ResourceUsage ReadPartialUsage(const std::filesystem::path& partial);
Status WritePartialUsage(const std::filesystem::path& partial,
                         const ResourceUsage& usage);

// Steps 1 to 4 above.
Status FinishPartial(const std::filesystem::path& workspace,
                     const std::string& stage,
                     const StageRecord& record);

// Completes what a killed program left half done.
Status RecoverStage(const std::filesystem::path& workspace,
                    const std::string& stage);

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_STAGE_OUTPUT_H_
