// SPDX-License-Identifier: BSD-3-Clause

#include "splat/search/exposure_search.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/text.h"
#include "splat/images/holdout.h"
#include "splat/optim/exposure.h"

namespace freegs::splat {
namespace {

constexpr int kProgressInterval = 10;

// The options of a trial. Milestones are shares of the iterations and adapt by
// themselves. Densifications come closer together, but with no fewer than 10
// steps between them unless the training itself has fewer.
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
    const int interval = schedule.densify_interval;
    schedule.densify_interval = std::clamp(
        static_cast<int>(interval * shorter), std::min(10, interval), interval);
  }
  trial.learning_rates.mean_decay_steps = steps;
  if (trial.budget > 0) {
    const double budget =
        std::pow(0.25, level) * static_cast<double>(trial.budget);
    trial.budget = std::max<int64_t>(1, static_cast<int64_t>(budget));
  }
  return trial;
}

// Which photographs the trial is trained on, in the order of `images`, and
// which others judge.
struct TrialPhotos {
  std::vector<size_t> trained;
  std::vector<size_t> others;
};

TrialPhotos SplitPhotos(const TrainingImages& images, int others_every) {
  std::vector<size_t> by_name(images.size());
  std::iota(by_name.begin(), by_name.end(), size_t{0});
  std::ranges::sort(by_name, NaturalLess, [&](size_t i) {
    return std::string(images.view(i).name);
  });
  TrialPhotos photos;
  for (size_t k = 0; k < by_name.size(); ++k) {
    const auto every = static_cast<size_t>(others_every);
    const bool other = k % every == every / 2;
    (other ? photos.others : photos.trained).push_back(by_name[k]);
  }
  std::ranges::sort(photos.trained);
  return photos;
}

// The photographs of a trial, at the level at which it is made.
struct TrialImages {
  TrainingImages trained;
  TrainingImages others;
  int level = 0;
};

// Trains to the end. Returns false when the deadline comes before it.
StatusOr<bool> RunTrial(const ExposureSearchOptions& options,
                        Trainer* trainer,
                        const CancellationToken* cancellation,
                        const ProgressFn& progress) {
  while (!trainer->done()) {
    if (IsCancelled(cancellation)) {
      return InterruptedError(
          "training: stopped while deciding about exposure");
    }
    if (options.deadline &&
        std::chrono::steady_clock::now() >= *options.deadline) {
      return false;
    }
    FREEGS_RETURN_IF_ERROR(trainer->Step(cancellation).status());
    if (progress && trainer->iteration() % kProgressInterval == 0) {
      progress({"deciding about exposure",
                static_cast<double>(trainer->iteration()),
                static_cast<double>(trainer->options().schedule.iterations),
                ""});
    }
  }
  return true;
}

// Measures the scene of a trial that has ended, with and without what it learnt
// of exposures, and chooses.
StatusOr<ExposureChoice> JudgeTrial(double min_gain_db,
                                    const Trainer& trainer,
                                    TrialImages* images,
                                    ThreadPool& pool,
                                    const CancellationToken* cancellation) {
  ExposureChoice choice;
  const RenderOptions& render = trainer.options().render;
  // 0 where masks leave nothing.
  const auto trained_psnr =
      [&](std::span<const PhotoExposure> exposures) -> StatusOr<double> {
    FREEGS_ASSIGN_OR_RETURN(const std::optional<double> psnr,
                            MeasureHoldoutPsnr({.model = trainer.model(),
                                                .render = render,
                                                .images = &images->trained,
                                                .level = images->level,
                                                .exposures = exposures,
                                                .cancellation = cancellation},
                                               pool));
    return psnr.value_or(0);
  };
  FREEGS_ASSIGN_OR_RETURN(choice.without.trained, trained_psnr({}));
  FREEGS_ASSIGN_OR_RETURN(choice.with.trained,
                          trained_psnr(trainer.Exposures()));
  FREEGS_ASSIGN_OR_RETURN(const std::optional<FittedPsnr> right_halves,
                          MeasureFittedHoldout({.model = trainer.model(),
                                                .render = render,
                                                .images = &images->others,
                                                .level = images->level,
                                                .cancellation = cancellation},
                                               pool));
  // Masks may have left nothing to judge by.
  if (!right_halves || choice.without.trained == 0) return choice;
  choice.without.held_out = right_halves->plain;
  choice.with.held_out = right_halves->fitted;
  const double gain = (choice.with.trained - choice.without.trained +
                       choice.with.held_out - choice.without.held_out) /
                      2;
  choice.learn = gain >= min_gain_db;
  return choice;
}

}  // namespace

Status ExposureSearchOptions::Check() const {
  if (!(min_gain_db >= 0) || level < 0) {
    return InvalidArgumentError(
        "level and min_gain_db of a search must not be negative");
  }
  if (others_every < 2) {
    return InvalidArgumentError("others_every must be at least 2");
  }
  if (!(trial_share >= 0 && trial_share <= 1) || min_trial_steps < 1) {
    return InvalidArgumentError("the steps of trials must be positive");
  }
  return Status();
}

StatusOr<std::optional<ExposureChoice>> SearchExposure(
    const ExposureSearchOptions& options,
    const TrainerOptions& training,
    const TrialScene& scene,
    ThreadPool& pool,
    const CancellationToken* cancellation,
    const ProgressFn& progress) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  FREEGS_RETURN_IF_ERROR(training.Check());
  const TrialPhotos photos = SplitPhotos(*scene.images, options.others_every);
  const std::optional<ExposureChoice> nothing_learnt = ExposureChoice();
  if (photos.others.empty()) return nothing_learnt;
  TrialImages images = {
      .trained = scene.images->Subset(photos.trained),
      .others = scene.images->Subset(photos.others),
      .level = std::min(options.level, scene.images->num_levels() - 1)};
  TrainerOptions trial = TrialOptions(options, training, images.level);
  trial.exposure.learn = true;
  Trainer trainer(trial, scene.initial, scene.extent, &images.trained, pool);
  const StatusOr<bool> ended =
      RunTrial(options, &trainer, cancellation, progress);
  if (ended.status().code() == StatusCode::kUnusableResult) {
    return nothing_learnt;
  }
  FREEGS_RETURN_IF_ERROR(ended.status());
  if (!*ended) return std::optional<ExposureChoice>();
  FREEGS_ASSIGN_OR_RETURN(
      const ExposureChoice choice,
      JudgeTrial(options.min_gain_db, trainer, &images, pool, cancellation));
  return std::optional(choice);
}

}  // namespace freegs::splat
