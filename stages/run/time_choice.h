// SPDX-License-Identifier: BSD-3-Clause
// Chooses the options with which a run takes no longer than somebody can wait.
// It goes from preset to preset (docs/speed_accuracy.md says what they are
// worth), and within a preset from few iterations to many.

#ifndef FREEGS_STAGES_RUN_TIME_CHOICE_H_
#define FREEGS_STAGES_RUN_TIME_CHOICE_H_

#include <functional>
#include <string>
#include <vector>

#include "core/status.h"
#include "pipeline/option_table.h"

namespace freegs::stages {

// What is expected of a run from now on.
struct ExpectedRun {
  double cameras = 0;         // Seconds of stages ingest, sfm and undistort.
  double others = 0;          // Seconds of the stages after them.
  double after_training = 0;  // The part of `others` after reconstruct.

  // Whether the time that the stages in `cameras` take will tell how fast this
  // machine is: something is known of each, and none goes on from an
  // interrupted run.
  bool cameras_tell_pace = true;

  // What the training does, by the user's options or those chosen.
  int iterations = 0;
  int max_image_size = 0;  // Pixels; 0: the photos' own size.

  double total() const { return cameras + others; }
};

// Foretells a run with these settings besides those that the user gave.
using ForetellFn = std::function<StatusOr<ExpectedRun>(
    const std::vector<pipeline::OptionSetting>& settings)>;

struct TimeChoice {
  std::vector<pipeline::OptionSetting> settings;
  ExpectedRun expected;

  // Whether the expected time is no longer than asked for. Otherwise this is
  // the shortest run there is.
  bool fits = true;
};

// "2,300 iterations with images of up to 800 pixels".
std::string TrainingText(const ExpectedRun& expected);

// The slowest choice that `foretell` expects to take no more than `seconds`.
// All choices set the same options. An error of `foretell` is returned.
StatusOr<TimeChoice> ChooseWithin(double seconds, const ForetellFn& foretell);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RUN_TIME_CHOICE_H_
