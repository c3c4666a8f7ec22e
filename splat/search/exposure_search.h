// SPDX-License-Identifier: BSD-3-Clause
// Decides whether training learns the exposure of each photograph
// (splat/optim/exposure.h): only where photographs look more like the scene for
// it. Where all have the same exposure the additional freedom costs quality.
//
// One short training learns the exposures, and its scene is shown with and
// without them. Two trainings, one that learns them and one that does not, tell
// less: they differ for many reasons, by more than exposure often matters.
//
//   FREEGS_ASSIGN_OR_RETURN(
//       const std::optional<ExposureChoice> choice,
//       SearchExposure({.deadline = deadline}, training,
//                      {trainer.model(), extent, &images}, pool, nullptr));
//   if (choice) trainer.SetExposureChoice(*choice);

#ifndef FREEGS_SPLAT_SEARCH_EXPOSURE_SEARCH_H_
#define FREEGS_SPLAT_SEARCH_EXPOSURE_SEARCH_H_

#include <chrono>
#include <optional>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "splat/images/training_images.h"
#include "splat/scene/gaussian_model.h"
#include "splat/train/exposure_choice.h"
#include "splat/train/trainer.h"

namespace freegs::splat {

struct ExposureSearchOptions {
  // Exposure is learnt if the scene of the trial gains at least so much by it,
  // on the mean of the two measures of TrialPsnr.
  double min_gain_db = 0.7;

  // Every others_every-th photograph, in the order of names, is kept from the
  // trial's training. TrialPsnr::held_out is measured on these.
  int others_every = 5;

  // The level of the image pyramid with which the trial is made.
  int level = 2;

  // The trial has this share of the iterations of the training, but no fewer
  // steps than the second value, if the training has so many.
  double trial_share = 0.25;
  int min_trial_steps = 200;

  // When a trial that is still going on ends without a result; not set: never.
  std::optional<std::chrono::steady_clock::time_point> deadline = {};

  Status Check() const;
};

// What the training proper is given of the scene; see Trainer.
struct TrialScene {
  const GaussianModel& initial;
  double extent = 0;
  TrainingImages* images = nullptr;
};

// Makes a short training on small images, the trial, which begins with
// scene.initial and learns the exposures. On images with a sixteenth of the
// pixels it has a sixteenth of the budget. When the images have too few levels
// for options.level, the coarsest is used. Nothing is learnt where there are no
// photographs to judge by: with less than 3 of them, or where masks leave
// nothing of those that were trained on or of the right halves of the others.
// Nothing is learnt either when the trial ends with kUnusableResult, as when it
// diverges: it says nothing about the training proper, which has other photos
// and steps. Returns nothing when options.deadline comes before the end of the
// trial. A choice is the same for any number of threads. Fails with
// kInvalidArgument when the options are wrong, with kBadInput when a photograph
// has become unreadable, and with kInterrupted when `cancellation` (null:
// never) asks to stop. Reports the steps of the trial to `progress`, if there
// is one.
StatusOr<std::optional<ExposureChoice>> SearchExposure(
    const ExposureSearchOptions& options,
    const TrainerOptions& training,
    const TrialScene& scene,
    ThreadPool& pool,
    const CancellationToken* cancellation,
    const ProgressFn& progress = nullptr);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_SEARCH_EXPOSURE_SEARCH_H_
