// SPDX-License-Identifier: BSD-3-Clause
// Finds out which results of a stage are in a workspace, and whether they hold.

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

// A stage, and the options that it was made from as text.
struct RunnerStage {
  std::unique_ptr<Stage> stage;
  std::map<std::string, std::string> options;  // Those that decide the result.
  std::map<std::string, std::string> other_options;
};

// The inputs and options that a run of the stage would have now.
struct CurrentInputs {
  StageFingerprint fingerprint;
  // Names of inputs with absolute paths: those that the user named, such as
  // photos and masks, wherever they lie. Once they have been read, the
  // workspace must be usable without them.
  std::set<std::string> given;
};

// Computes the fingerprint of what the stage would read now. It does not depend
// on where the workspace lies: inputs inside the workspace are named by their
// relative paths, the folder of photos is "photos", and others are named by
// their file names.
CurrentInputs GatherInputs(const RunnerStage& stage,
                           const StageContext& context,
                           FingerprintCache& cache);

enum class StageStatus {
  kMissing,      // Never run.
  kDone,         // The result holds.
  kStale,        // There is a result, but of other inputs or options.
  kInterrupted,  // A run was killed or cancelled.
  kFailed,       // The last run ended with an error.
  kForeign,  // A folder without stage.json, which this program did not make.
};
const char* StageStatusName(StageStatus status);

// Whether the next run goes on from what a failed one saved.
bool IsWorthContinuing(const StageRecord& failed);

struct StageState {
  StageStatus status = StageStatus::kMissing;
  std::string reason;      // One line: why it is not done. Empty if it is done.
  std::string note;        // A remark on a result that is kept.
  bool resumable = false;  // STAGE.partial can be continued.
  // Why STAGE.partial cannot be continued now, but could be later: "input
  // photos is missing; ...". Empty otherwise.
  std::string waits_for;
  // The result would hold, but somebody deleted files of it.
  bool lacks_files = false;
  // The result holds, but its stage.json says of inputs with the same content
  // that they lay elsewhere. `result` has the paths where they lie now.
  bool inputs_moved = false;
  std::optional<StageRecord> result;   // From STAGE/.
  std::optional<StageRecord> attempt;  // From STAGE.partial/ if its run ended.
};

// `read_later` are the files and folders of the stage's output that later
// stages read, relative to its folder.
StageState InspectStage(const std::filesystem::path& workspace,
                        const std::string& stage,
                        const CurrentInputs& now,
                        const std::vector<std::filesystem::path>& read_later);

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_STAGE_STATE_H_
