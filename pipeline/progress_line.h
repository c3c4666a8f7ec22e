// SPDX-License-Identifier: BSD-3-Clause
// Shows the progress of a long step. On a terminal this is one line with the
// rate and the time left, which is drawn again and again. Elsewhere it is a
// plain line now and then.

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

// Returns a text such as "training 3200/7000 46% 52.1/s 1 min 13 s left, loss
// 0.03". `rate` is in units per second. When it is 0, which means unknown,
// neither the rate nor the time left is shown.
std::string FormatProgress(const Progress& progress, double rate);

// Estimates how fast the work of one step goes. It looks at the last half
// minute, so that the rate follows a step that becomes slower, and at 20 units
// of work or more. Otherwise the time left would jump to hours after the mapper
// has spent a minute on adjusting all photos.
class ProgressRate {
 public:
  // Returns units per second, 0 when that is not known yet. `now` is in seconds
  // and never goes back.
  double Update(double now, const Progress& progress);

 private:
  std::string step_;
  std::deque<std::pair<double, double>> recent_;  // Time, and what was done.
};

// What a run is expected to take from the beginning of a stage on, in seconds.
// 0 means that nothing is known.
struct ExpectedSeconds {
  double stage = 0;
  double later = 0;  // The stages after it.
};

// The line of one stage:
//
//   ProgressLine line(&logger, "reconstruct", {.stage = 75, .later = 30});
//   for (int i = 0; i < n; ++i) line.Report({"training", i, n, ""});
class ProgressLine {
 public:
  using Clock = std::function<double()>;  // Seconds; never goes back.

  // Every line begins with `prefix`, the name of the stage, and with the time
  // that is left for the whole run where something is expected. `logger` must
  // outlive the object. Without a clock it uses the steady clock.
  ProgressLine(Logger* logger,
               std::string prefix,
               ExpectedSeconds expected = {},
               Clock clock = {});

  // Erases the line.
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  // Several threads may call this, and often: the line is drawn at most ten
  // times per second. Without a terminal, a step writes at most one line in ten
  // seconds.
  void Report(const Progress& progress);

 private:
  // " (1 min 20 s left for all)", or nothing. A step that says itself how long
  // it will last is believed when that is longer than what was expected.
  std::string LeftText(double now, const Progress& progress, double rate) const;

  std::mutex mutex_;
  Logger* logger_;
  const std::string prefix_;
  const ExpectedSeconds expected_;
  const Clock clock_;
  const double begin_;
  std::string step_;
  double last_shown_ = 0;
  bool shown_ = false;
  ProgressRate rate_;
};

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_PROGRESS_LINE_H_
