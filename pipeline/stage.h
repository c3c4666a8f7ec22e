// SPDX-License-Identifier: BSD-3-Clause
// What a stage is to the runner: a name, what it reads, and a Run that fills a
// folder. The runner owns everything else (fingerprints, skipping, the
// temporary folder, stage.json, progress, interruption).

#ifndef FREEGS_PIPELINE_STAGE_H_
#define FREEGS_PIPELINE_STAGE_H_

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"

namespace freegs::pipeline {

// Severity of a log line. Lines go to stderr and to WORKSPACE/log.txt.
enum class LogLevel { kInfo, kWarning, kError };
using LogFn = std::function<void(LogLevel, const std::string&)>;

// Everything a running stage is given.
struct StageContext {
  // The workspace; earlier stages' finished output lies in workspace / NAME.
  std::filesystem::path workspace;

  // Where this stage writes. A temporary folder beside the final one: the
  // runner renames it to workspace / name() when Run succeeds. It is kept when
  // a run is killed, and handed back unchanged to the next Run whose inputs and
  // options are the same, so checkpoints written here are found again.
  std::filesystem::path output;

  // True when `output` holds what an interrupted Run with the same inputs and
  // options left behind.
  bool resuming = false;

  // Photo folder given on the command line (only ingest reads it).
  std::filesystem::path images;

  ThreadPool* pool = nullptr;
  const CancellationToken* cancellation = nullptr;
  ProgressFn progress;
  LogFn log;

  // Seconds between checkpoints of long stages.
  double checkpoint_interval_seconds = 60;

  // Wall seconds that earlier, interrupted Runs into this `output` took.
  double earlier_seconds = 0;

  // Free-form facts a stage wants to see in stage.json (counts, warnings).
  nlohmann::json summary = nlohmann::json::object();
};

class Stage {
 public:
  virtual ~Stage() = default;

  // The folder in the workspace and the section of the options.
  virtual std::string_view name() const = 0;

  // Raised when the code changes what it writes, so that results of older
  // programs are redone.
  virtual int version() const { return 1; }

  // Files and folders whose content decides the result, relative to the
  // workspace or absolute (photos, an imported model). Folders count with all
  // files below them. The runner fingerprints them by content.
  virtual std::vector<std::filesystem::path> Inputs(
      const StageContext& context) const = 0;

  // Fills context.output. On cancellation: saves a checkpoint and returns
  // kInterrupted.
  virtual Status Run(StageContext& context) = 0;
};

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_STAGE_H_
