// SPDX-License-Identifier: BSD-3-Clause
// Runs stages in order, skips those whose result holds, and says why it redoes
// the others.

#ifndef FREEGS_PIPELINE_STAGE_RUNNER_H_
#define FREEGS_PIPELINE_STAGE_RUNNER_H_

#include <filesystem>
#include <string>
#include <vector>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "pipeline/fingerprint.h"
#include "pipeline/logger.h"
#include "pipeline/stage.h"
#include "pipeline/stage_state.h"

namespace freegs::pipeline {

struct StageRunnerOptions {
  std::filesystem::path workspace;  // An existing folder, locked by the caller.
  std::filesystem::path images;     // Photo folder; absolute.

  // First and last stage to look at; empty takes the first and the last.
  // Stages before `from` are used as they lie in the workspace.
  std::string from;
  std::string to;

  // A stage to redo although its result holds; empty for none.
  std::string forced;

  int num_threads = 0;  // 0 takes one per available core.
  double checkpoint_interval_seconds = 60;

  // Seconds between notes of the time used so far, for a run that is killed.
  double usage_interval_seconds = 5;
};

// One line of a workspace's status.
struct StageReport {
  std::string stage;
  StageState state;
};

class StageRunner {
 public:
  // `cancellation` and `logger` must outlive the runner.
  StageRunner(std::vector<RunnerStage> stages,
              StageRunnerOptions options,
              const CancellationToken& cancellation,
              Logger& logger);

  // kInvalidArgument for an unknown stage name; kInterrupted after a checkpoint
  // when cancelled; otherwise the first stage's error, its name before the
  // message. What was finished or begun before an error stays.
  Status Run();

  // What Run would find, without running anything. A stage after one that is
  // not done is reported as stale.
  StatusOr<std::vector<StageReport>> Inspect();

  // Completes what a killed program left half done, in all stages.
  Status Recover();

 private:
  Status CheckOptions() const;
  StageContext MakeContext(const RunnerStage& stage) const;
  Status RunStage(RunnerStage& stage,
                  const StageFingerprint& fingerprint,
                  bool resume,
                  ThreadPool& pool);
  size_t IndexOf(const std::string& name) const;
  std::string StageNames() const;

  std::vector<RunnerStage> stages_;
  const StageRunnerOptions options_;
  const CancellationToken& cancellation_;
  Logger& logger_;
  FingerprintCache cache_;
};

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_STAGE_RUNNER_H_
