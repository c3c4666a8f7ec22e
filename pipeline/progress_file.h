// SPDX-License-Identifier: BSD-3-Clause
// WORKSPACE/progress.json: what a run is doing now, for programs that look on.
//
//   {"stage": "reconstruct", "step": "training", "done": 1200, "total": 2500,
//    "seconds_left": 73.5}
//
// total is 0 and seconds_left null when they are not known. The file is there
// as long as a stage runs. A run that was killed leaves its last one behind
// until the next run begins, so it tells something only while the workspace is
// locked.

#ifndef FREEGS_PIPELINE_PROGRESS_FILE_H_
#define FREEGS_PIPELINE_PROGRESS_FILE_H_

#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "core/cancellation.h"
#include "core/status.h"
#include "pipeline/progress_line.h"

namespace freegs::pipeline {

// Deletes progress.json, and the preview that a stage has left
// (StageContext::preview).
void RemoveProgress(const std::filesystem::path& workspace);

// The file of one stage. At its end it calls RemoveProgress.
class ProgressFile {
 public:
  using Clock = std::function<double()>;  // Seconds; never goes back.

  // Writes that the stage begins. Without a clock it uses the steady clock.
  ProgressFile(std::filesystem::path workspace,
               std::string stage,
               Clock clock = {});
  ~ProgressFile();
  ProgressFile(const ProgressFile&) = delete;
  ProgressFile& operator=(const ProgressFile&) = delete;

  // Several threads may call this, and often: the file is written at most once
  // a second. A disk that is full is no error.
  void Report(const Progress& progress);

 private:
  void Write(const Progress& progress, double rate);

  std::mutex mutex_;
  const std::filesystem::path workspace_;
  const std::string stage_;
  const Clock clock_;
  ProgressRate rate_;
  double last_written_ = 0;
};

struct RunProgress {
  std::string stage;
  std::string step;
  double done = 0;
  double total = 0;
  std::optional<double> seconds_left;
};

// kBadInput when there is no such file or when it is malformed.
StatusOr<RunProgress> ReadProgressFile(const std::filesystem::path& workspace);

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_PROGRESS_FILE_H_
