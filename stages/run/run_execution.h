// SPDX-License-Identifier: BSD-3-Clause
// What commands run and stage do once their words are understood.

#ifndef FREEGS_STAGES_RUN_RUN_EXECUTION_H_
#define FREEGS_STAGES_RUN_RUN_EXECUTION_H_

#include <chrono>
#include <filesystem>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "core/cancellation.h"
#include "core/status.h"
#include "pipeline/option_table.h"
#include "pipeline/workspace.h"
#include "stages/registry/pipeline_options.h"

namespace freegs::stages {

struct RunRequest {
  std::filesystem::path workspace;  // An existing folder, locked by the caller.
  pipeline::WorkspaceInfo info;     // With the folder of the photos.

  // The first and the last stage; empty means the first and the last of all.
  std::string from;
  std::string to;

  // A stage to run again although its result holds; empty for none.
  std::string forced;
  // Why, see pipeline::StageRunnerOptions; the default of it where this is
  // empty.
  std::string forced_reason;

  // When the run is wanted to end; see pipeline::StageContext::deadline.
  std::optional<std::chrono::steady_clock::time_point> deadline;

  // See pipeline::StageRunnerOptions; the default of it where this is empty.
  std::string way_on;

  // What is to be said about remembered options; may be empty.
  std::string note;
};

// Runs the stages, and logs to `err` and the workspace's log file. `table` is
// the table over the same options. The errors are those of StageRunner::Run.
Status Execute(const RunRequest& request,
               const PipelineOptions& options,
               const pipeline::OptionTable& table,
               std::ostream& err,
               const CancellationToken& cancellation);

// Runs all stages within so many seconds (timed_run.h). `settings` are those of
// the user, among them preset auto. The options that are chosen are remembered,
// so that `run WORKSPACE` goes on with them. A training that an earlier run
// ended before all its iterations, or before it was decided whether exposure is
// learnt, is done anew. Also returns errors of settings.
Status ExecuteWithin(double seconds,
                     const std::vector<pipeline::OptionSetting>& settings,
                     const RunRequest& request,
                     std::ostream& err,
                     const CancellationToken& cancellation);

// Runs all stages like ExecuteWithin, but until holdout photos have at least
// this PSNR in dB (psnr_run.h). kBadInput if the scene has no holdout photos.
Status ExecuteAtLeast(double psnr,
                      const std::vector<pipeline::OptionSetting>& settings,
                      const RunRequest& request,
                      std::ostream& err,
                      const CancellationToken& cancellation);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RUN_RUN_EXECUTION_H_
