// SPDX-License-Identifier: BSD-3-Clause
// Runs the stages of a pipeline in order. It skips stages whose results hold,
// and says why it runs the others again.

#ifndef FREEGS_PIPELINE_STAGE_RUNNER_H_
#define FREEGS_PIPELINE_STAGE_RUNNER_H_

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "pipeline/fingerprint.h"
#include "pipeline/forecast/stage_need.h"
#include "pipeline/logger.h"
#include "pipeline/stage.h"
#include "pipeline/stage_state.h"

namespace freegs::pipeline {

struct StageRunnerOptions {
  std::filesystem::path workspace;  // An existing folder, locked by the caller.
  std::filesystem::path images;     // The folder of photos; absolute.

  // The first and the last stage to run; empty means the first and the last of
  // all. The results of stages before `from` are used as they are.
  std::string from;
  std::string to;

  // A stage to run again although its result holds, and why; empty for none.
  std::string forced;
  std::string forced_reason = "redone as asked";

  int num_threads = 0;  // 0 takes one per available core.
  double checkpoint_interval_seconds = 60;

  // What an interrupted run tells the user to do to go on.
  std::string way_on = "the same command";

  // When the run is wanted to end; see StageContext::deadline.
  std::optional<std::chrono::steady_clock::time_point> deadline;

  // Seconds between writes of usage.json, which keeps the time used so far for
  // the case that the program is killed.
  double usage_interval_seconds = 5;
};

// The state of one stage in a workspace.
struct StageReport {
  std::string stage;
  StageState state;
};

// Runs stages in a workspace:
//
//   FREEGS_ASSIGN_OR_RETURN(const WorkspaceLock lock,
//                           WorkspaceLock::Acquire(options.workspace));
//   StageRunner runner(std::move(stages), options, cancellation, logger);
//   FREEGS_RETURN_IF_ERROR(runner.Run());
class StageRunner {
 public:
  // `cancellation` and `logger` must outlive the runner.
  StageRunner(std::vector<RunnerStage> stages,
              StageRunnerOptions options,
              const CancellationToken& cancellation,
              Logger& logger);

  // Returns kInvalidArgument for an unknown stage name, kInterrupted when
  // cancelled (after a checkpoint), or else the error of the first stage that
  // fails, with its name before the message. What was finished or begun before
  // the error stays.
  Status Run();

  // Returns the state of each stage without running any. A stage that comes
  // after one that is not done is reported as stale. A cancelled runner may
  // report anything.
  std::vector<StageReport> Inspect();

  // Foretells what a run would need, stage by stage. Writes nothing. The errors
  // are those of unknown stage names, and kInterrupted.
  StatusOr<std::vector<StageForecast>> Forecast();

  // Calls RecoverStage for every stage, and removes what a killed run said of
  // itself (RemoveProgress). Run begins with this; Inspect and Forecast take
  // the workspace as it is.
  Status Recover();

 private:
  // How a stage begins.
  struct StageStart {
    StageNeed need = {};
    double later_seconds = 0;  // What the stages after it are expected to take.
    StageFingerprint fingerprint = {};
    bool resume = false;  // Whether it goes on from STAGE.partial.
  };

  Status CheckOptions() const;
  // kBadInput if a stage before First() lacks a result that the run reads.
  Status CheckStart() const;
  // Whether a stage in this state has to run; state->reason then says why.
  // `redone` is the first stage that this run has made again; empty for none.
  // kBadInput says what is in the way.
  StatusOr<bool> NeedsRun(const std::string& name,
                          const std::string& redone,
                          StageState* state);
  // The stages of a run: First() and those after it, before End().
  size_t First() const;
  size_t End() const;
  std::vector<StageReport> States();
  std::vector<StageForecast> Forecast(ThreadPool& pool);
  // What each stage needs, from the files of those that are done. Where a stage
  // is not, those after it build on what it is expected to make.
  std::vector<StageNeed> NeedsOfStages(const std::vector<bool>& done,
                                       ThreadPool& pool) const;
  StageContext MakeContext(const RunnerStage& stage) const;
  // What stages after this one read of its output, relative to its folder.
  std::vector<std::filesystem::path> ReadLater(const std::string& stage) const;
  // What the stages from number `first` up to `end`, which is not one of them,
  // read of the output of `stage`, relative to its folder.
  std::vector<std::filesystem::path> ReadBy(size_t first,
                                            size_t end,
                                            const std::string& stage) const;
  Status RunStage(RunnerStage& stage, StageStart start, ThreadPool& pool);
  Status PutInPlace(const RunnerStage& stage,
                    const StageContext& context,
                    StageRecord* record);
  Status NoteFailure(const RunnerStage& stage,
                     const Status& status,
                     const StageContext& context,
                     StageRecord* record);
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
