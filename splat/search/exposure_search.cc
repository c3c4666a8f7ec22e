// SPDX-License-Identifier: BSD-3-Clause

#include "splat/search/exposure_search.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "splat/images/holdout.h"
#include "splat/optim/exposure.h"

namespace freegs::splat {
namespace {

// The options of a trial. Milestones are shares of the iterations and adapt by
// themselves; intervals must be shortened.
TrainerOptions TrialOptions(const ExposureSearchOptions& options,
                            const TrainerOptions& training,
                            int level) {
  TrainerOptions trial = training;
  ScheduleOptions& schedule = trial.schedule;
  const int wanted =
      std::max(static_cast<int>(options.trial_share * schedule.iterations),
               options.min_trial_steps);
  const int steps = std::min(wanted, schedule.iterations);
  const double shorter = std::min(1.0, 1.0 * steps / schedule.iterations);
  schedule.iterations = steps;
  schedule.finest_level = std::max(schedule.finest_level, level);
  schedule.depth_reinit_at.clear();
  if (schedule.densify_interval > 0) {
    schedule.densify_interval =
        std::max(10, static_cast<int>(schedule.densify_interval * shorter));
  }
  trial.learning_rates.mean_decay_steps = steps;
  if (trial.budget > 0) {
    const double budget =
        std::pow(0.25, level) * static_cast<double>(trial.budget);
    trial.budget = std::max<int64_t>(1, static_cast<int64_t>(budget));
  }
  return trial;
}

}  // namespace

Status ExposureSearchOptions::Check() const {
  if (!(min_gain_db >= 0) || level < 0) {
    return InvalidArgumentError(
        "level and min_gain_db of a search must not be negative");
  }
  if (!(trial_share >= 0 && trial_share <= 1) || min_trial_steps < 1) {
    return InvalidArgumentError("the steps of trials must be positive");
  }
  return Status();
}

StatusOr<ExposureChoice> SearchExposure(const ExposureSearchOptions& options,
                                        const TrainerOptions& training,
                                        const GaussianModel& initial,
                                        double scene_extent,
                                        const FittedJudge& judge,
                                        TrainingImages* images,
                                        ThreadPool* pool,
                                        const CancellationToken* cancellation) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  const int level = std::min(options.level, images->num_levels() - 1);
  TrainerOptions trial = TrialOptions(options, training, level);
  trial.exposure.learn = true;
  Trainer trainer(trial, initial, scene_extent, images, pool);
  while (!trainer.done()) {
    if (IsCancelled(cancellation)) {
      return InterruptedError(
          "training: stopped while deciding about exposure");
    }
    FREEGS_RETURN_IF_ERROR(trainer.Step().status());
  }
  const auto training_psnr =
      [&](std::span<const PhotoExposure> exposures) -> StatusOr<double> {
    FREEGS_ASSIGN_OR_RETURN(
        const HoldoutReport report,
        MeasureHoldout(
            trainer.model(), training.render, images, *pool, level, exposures));
    return report.mean_psnr;
  };
  ExposureChoice choice;
  FREEGS_ASSIGN_OR_RETURN(choice.without.training, training_psnr({}));
  FREEGS_ASSIGN_OR_RETURN(choice.with.training,
                          training_psnr(trainer.Exposures()));
  FREEGS_ASSIGN_OR_RETURN(const std::optional<FittedPsnr> holdout,
                          judge(trainer.model(), level));
  if (!holdout) return choice;
  choice.without.holdout = holdout->plain;
  choice.with.holdout = holdout->fitted;
  const double gain = (choice.with.training - choice.without.training +
                       choice.with.holdout - choice.without.holdout) /
                      2;
  choice.learn = gain >= options.min_gain_db;
  return choice;
}

}  // namespace freegs::splat
