// SPDX-License-Identifier: BSD-3-Clause
// A run that ends within a time: `run --within 5m`.
//
// Options are chosen twice: before the run, by what all stages are expected to
// take, and again once the cameras are known, by the time that is left then.
// Nothing is known of a film until its pictures have been taken from it, so
// this is done before the first choice. If training is slower than expected
// even so, it stops when the time of the stages after it has come.

#ifndef FREEGS_STAGES_RUN_TIMED_RUN_H_
#define FREEGS_STAGES_RUN_TIMED_RUN_H_

#include <functional>
#include <string>
#include <vector>

#include "core/status.h"
#include "pipeline/option_table.h"
#include "pipeline/stage.h"
#include "stages/run/time_choice.h"

namespace freegs::stages {

// How far a part of the run goes: to the photos that there are, to the cameras,
// to the end.
enum class RunPart { kPhotos, kCameras, kAll };

// What a timed run needs of the world.
struct TimedRunTasks {
  // Seconds on a clock that only goes forward.
  std::function<double()> now;

  ForetellFn foretell;

  // Brings the stages of a part up to date. The training of the last part
  // stops in time for a run that ends at `end` on the clock.
  std::function<Status(const std::vector<pipeline::OptionSetting>& settings,
                       RunPart part,
                       double end)>
      run;

  pipeline::LogFn log;
};

// Runs all stages within `seconds`, if that can be done, and says what it
// expects and what became of it. A run that takes longer is no error. Returns
// the errors of the tasks.
Status RunWithin(double seconds, const TimedRunTasks& tasks);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RUN_TIMED_RUN_H_
