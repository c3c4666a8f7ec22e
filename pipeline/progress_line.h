// SPDX-License-Identifier: BSD-3-Clause
// How far a long step is: one line with rate and time left on a terminal, a
// plain line now and then otherwise.

#ifndef FREEGS_PIPELINE_PROGRESS_LINE_H_
#define FREEGS_PIPELINE_PROGRESS_LINE_H_

#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <utility>

#include "core/cancellation.h"
#include "pipeline/logger.h"

namespace freegs::pipeline {

// "training 3200/7000 46% 52.1/s 1 min 13 s left, loss 0.03". A rate of 0 means
// unknown: then neither rate nor time left is shown.
std::string FormatProgress(const Progress& progress, double rate);

class ProgressLine {
 public:
  using Clock = std::function<double()>;  // Seconds, never going back.

  // `prefix` begins every line: the stage's name. `logger` must outlive this.
  // An empty clock takes the steady clock.
  ProgressLine(Logger* logger, std::string prefix, Clock clock = {});

  // Erases the line.
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  // Thread-safe and cheap: redraws at most ten times a second, and without a
  // terminal writes at most one line per ten seconds of a step.
  void Report(const Progress& progress);

 private:
  double Rate(double now, double done);

  std::mutex mutex_;
  Logger* logger_;
  const std::string prefix_;
  const Clock clock_;
  std::string step_;
  double last_shown_ = 0;
  bool shown_ = false;

  // (time, done) of the recent past; the rate is taken over it, so that it
  // follows a step that becomes slower.
  std::deque<std::pair<double, double>> recent_;
};

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_PROGRESS_LINE_H_
