// SPDX-License-Identifier: BSD-3-Clause
// What lies in a workspace of one stage, and whether it still holds.

#ifndef FREEGS_PIPELINE_STAGE_STATE_H_
#define FREEGS_PIPELINE_STAGE_STATE_H_

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/status.h"
#include "pipeline/fingerprint.h"
#include "pipeline/stage.h"
#include "pipeline/stage_record.h"

namespace freegs::pipeline {

// A stage with the options it was made from, as text.
struct RunnerStage {
  std::unique_ptr<Stage> stage;
  std::map<std::string, std::string> options;  // Those that decide the result.
  std::map<std::string, std::string> other_options;
};

// What the stage would be run on now.
struct CurrentInputs {
  StageFingerprint fingerprint;
  // Names of inputs that lie outside the workspace. The workspace must remain
  // usable without them once they were read.
  std::set<std::string> external;
};

// Inputs inside the workspace are named by their relative path, the photo
// folder "photos", others by their file name: nothing depends on where the
// workspace lies.
CurrentInputs GatherInputs(const RunnerStage& stage,
                           const StageContext& context,
                           FingerprintCache& cache);

enum class StageStatus {
  kMissing,      // Never run.
  kDone,         // The result holds.
  kStale,        // There is a result, of other inputs or options.
  kInterrupted,  // A run was killed or cancelled.
  kFailed,       // The last run ended with an error.
  kForeign,      // A folder without stage.json: somebody else's result.
};
const char* StageStatusName(StageStatus status);

struct StageState {
  StageStatus status = StageStatus::kMissing;
  std::string reason;      // One line: why it is not done. Empty if it is.
  std::string note;        // Something to tell about a result that is kept.
  bool resumable = false;  // STAGE.partial can be continued.
  std::optional<StageRecord> result;   // Of STAGE/.
  std::optional<StageRecord> attempt;  // Of STAGE.partial/, if it ended.
};

StageState InspectStage(const std::filesystem::path& workspace,
                        const std::string& stage,
                        const CurrentInputs& now);

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_STAGE_STATE_H_
