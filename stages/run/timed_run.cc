// SPDX-License-Identifier: BSD-3-Clause

#include "stages/run/timed_run.h"

#include <algorithm>
#include <cmath>

#include "core/number_text.h"

namespace freegs::stages {
namespace {

using pipeline::LogLevel;
using pipeline::OptionSetting;

// The share of the time that is given away, since training can be shortened
// when it is slow, but nothing makes use of time that is left at the end.
constexpr double kShare = 0.95;

// The share of the time after which the run should be over even if training
// has to be shortened.
constexpr double kLatest = 0.97;

// How many times as long as foretold the cameras took. Short runs say nothing.
double Delay(double took, double expected) {
  constexpr double kLeastSeconds = 3;
  if (took < kLeastSeconds || expected < kLeastSeconds) return 1;
  return std::clamp(took / expected, 0.25, 4.0);
}

// How many times as long the rest is taken to last then. Most of the delay lies
// in the photos: in runs of four scenes on one machine the cameras took 0.9 to
// 2.1 times as long as foretold, and the training 0.9 to 1.0 times.
double PaceOf(double delay) { return std::pow(delay, 0.25); }

// The settings, but those of stage sfm as they were before.
std::vector<OptionSetting> WithCameras(
    std::vector<OptionSetting> settings,
    const std::vector<OptionSetting>& before) {
  for (size_t k = 0; k < settings.size(); ++k) {
    if (settings[k].name.starts_with("sfm.")) settings[k] = before[k];
  }
  return settings;
}

// Foretells with the pace, and without changing the options of stage sfm, which
// is done.
ForetellFn AfterCameras(const ForetellFn& foretell,
                        const std::vector<OptionSetting>& before,
                        double pace) {
  return
      [&foretell, &before, pace](
          const std::vector<OptionSetting>& settings) -> StatusOr<ExpectedRun> {
        FREEGS_ASSIGN_OR_RETURN(ExpectedRun expected,
                                foretell(WithCameras(settings, before)));
        expected.others *= pace;
        expected.after_training *= pace;
        return expected;
      };
}

}  // namespace

Status RunWithin(double seconds, const TimedRunTasks& tasks) {
  const double begin = tasks.now();
  const double end = begin + kLatest * seconds;
  const std::string within = "run: within " + FormatSeconds(seconds) + ": ";
  FREEGS_ASSIGN_OR_RETURN(TimeChoice first,
                          ChooseWithin(kShare * seconds, tasks.foretell));
  double photos = 0;
  if (first.expected.total() == 0) {
    FREEGS_RETURN_IF_ERROR(tasks.run(first.settings, RunPart::kPhotos, end));
    photos = tasks.now() - begin;
    FREEGS_ASSIGN_OR_RETURN(
        first, ChooseWithin(kShare * (seconds - photos), tasks.foretell));
  }
  tasks.log(first.fits ? LogLevel::kInfo : LogLevel::kWarning,
            within + TrainingText(first.expected) + " are expected to take " +
                FormatSeconds(photos + first.expected.total()) +
                (first.fits ? "" : ", and nothing shorter makes a scene"));
  FREEGS_RETURN_IF_ERROR(tasks.run(first.settings, RunPart::kCameras, end));
  const double cameras = tasks.now() - begin;

  const double delay = first.expected.cameras_tell_pace
                           ? Delay(cameras - photos, first.expected.cameras)
                           : 1;
  const double pace = PaceOf(delay);
  const ForetellFn foretell =
      AfterCameras(tasks.foretell, first.settings, pace);
  FREEGS_ASSIGN_OR_RETURN(TimeChoice second,
                          ChooseWithin(kShare * (seconds - cameras), foretell));
  second.settings = WithCameras(second.settings, first.settings);
  const double expected = cameras + second.expected.total();
  tasks.log(second.fits ? LogLevel::kInfo : LogLevel::kWarning,
            within + "the cameras took " + FormatSeconds(cameras) + "; " +
                TrainingText(second.expected) + " are expected to end after " +
                FormatSeconds(expected));
  // Training ends in time for what the forecasts say of the stages after it. On
  // a slow machine they take more. So more of the delay counts here: an early
  // end costs less than a late one.
  const double after = second.expected.after_training / pace;
  const double more = std::max(0.0, after * (std::sqrt(delay) - 1));
  FREEGS_RETURN_IF_ERROR(tasks.run(second.settings, RunPart::kAll, end - more));
  tasks.log(LogLevel::kInfo,
            "run: took " + FormatSeconds(tasks.now() - begin) + " of " +
                FormatSeconds(seconds) + "; " + FormatSeconds(expected) +
                " were expected before the training");
  return Status();
}

}  // namespace freegs::stages
