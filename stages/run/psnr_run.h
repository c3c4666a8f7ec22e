// SPDX-License-Identifier: BSD-3-Clause
// A run that does no more than an accuracy needs: `run --at-least psnr=27`.
//
// Nothing that is known before a training tells its PSNR to within a few dB. So
// a short training is the first guess. Where it is not enough, its PSNR and
// what more iterations usually gain foretell which longer one is. Each training
// has at least twice the iterations of the one before, so all together take at
// most twice as long as the last.

#ifndef FREEGS_STAGES_RUN_PSNR_RUN_H_
#define FREEGS_STAGES_RUN_PSNR_RUN_H_

#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "core/status.h"
#include "pipeline/option_table.h"
#include "pipeline/stage.h"

namespace freegs::stages {

// The dB of "psnr=27", from 1 to 100. kInvalidArgument for other texts.
StatusOr<double> ParsePsnrGoal(std::string_view text);

// Whether such a run chooses the value of this option itself.
bool IsChosenByPsnr(std::string_view option);

// The error for a user who has set an option that such a run chooses.
Status ChosenByPsnrError(const std::string& option);

// What earlier runs have done of a training.
struct TrainingState {
  // The PSNR of the holdout photos, in dB, if the training is done.
  std::optional<double> psnr;

  // Whether it was interrupted and can be continued.
  bool begun = false;
};

// What such a run needs of the world.
struct PsnrRunTasks {
  // What there is of the training with these settings.
  std::function<StatusOr<TrainingState>(
      const std::vector<pipeline::OptionSetting>& settings)>
      look;

  // Brings the stages up to the training up to date. Returns the PSNR of the
  // holdout photos, in dB.
  std::function<StatusOr<double>(
      const std::vector<pipeline::OptionSetting>& settings)>
      train;

  // Brings all stages up to date.
  std::function<Status(const std::vector<pipeline::OptionSetting>& settings)>
      finish;

  pipeline::LogFn log;
};

// Trains until the holdout photos have at least this PSNR in dB, until there is
// no longer training, or until two trainings foretell that it stays out of
// reach, and finishes the scene with the last training. Says what it expects
// and what became of it. A scene of a lower PSNR is no error. Returns the
// errors of the tasks.
Status RunAtLeast(double psnr, const PsnrRunTasks& tasks);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RUN_PSNR_RUN_H_
