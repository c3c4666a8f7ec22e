// SPDX-License-Identifier: BSD-3-Clause
// Decides whether training learns the exposure of each photograph
// (splat/optim/exposure.h): only where photographs that training never sees
// gain from it. Where all photographs have the same exposure, or one that
// changes slowly along the way of the camera, so that colours which depend on
// the viewing direction follow it, the additional freedom costs quality.
//
//   const QualityJudge judge =
//       [&](const GaussianModel& model,
//           std::span<const PhotoExposure> exposures,
//           int level) -> StatusOr<HoldoutPsnr> {
//     HoldoutPsnr psnr;
//     ... MeasureHoldout and MeasureFittedHoldout ...
//     return psnr;
//   };
//   FREEGS_ASSIGN_OR_RETURN(
//       const ExposureChoice choice,
//       SearchExposure({}, training, trainer.model(), extent, judge, &images,
//                      &pool, nullptr));
//   trainer.KeepTo(choice);

#ifndef FREEGS_SPLAT_SEARCH_EXPOSURE_SEARCH_H_
#define FREEGS_SPLAT_SEARCH_EXPOSURE_SEARCH_H_

#include <functional>
#include <span>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "splat/images/training_images.h"
#include "splat/optim/exposure.h"
#include "splat/scene/gaussian_model.h"
#include "splat/train/exposure_choice.h"
#include "splat/train/trainer.h"

namespace freegs::splat {

// Measures a model on photographs that training does not see, at a level of
// their image pyramid. `exposures` are those learnt (Trainer::Exposures). An
// error ends the search, which returns it.
using QualityJudge = std::function<StatusOr<HoldoutPsnr>(
    const GaussianModel& model,
    std::span<const PhotoExposure> exposures,
    int level)>;

struct ExposureSearchOptions {
  // Exposure is learnt if the trial with it gains at least so much, on the mean
  // of two measures: the PSNR with fitted colours and the PSNR without.
  double min_gain_db = 0.1;

  // The level of the image pyramid with which the trials are made.
  int level = 2;

  // A trial has this share of the iterations of the training, but no fewer
  // steps than the second value, if the training has so many.
  double trial_share = 0.25;
  int min_trial_steps = 200;

  Status Check() const;
};

// Makes two short trainings on small images, the trials: one with the exposure
// of each photograph learnt, one without. Both begin with `initial` and use the
// same views in the same order. A trial on images with a sixteenth of the
// pixels has a sixteenth of the budget. When `images` has too few levels for
// options.level, the coarsest is used. The result is the same for any number of
// threads. Fails with kInvalidArgument when the options are wrong, and with
// kInterrupted when `cancellation` (null: never) asks to stop.
StatusOr<ExposureChoice> SearchExposure(const ExposureSearchOptions& options,
                                        const TrainerOptions& training,
                                        const GaussianModel& initial,
                                        double scene_extent,
                                        const QualityJudge& judge,
                                        TrainingImages* images,
                                        ThreadPool* pool,
                                        const CancellationToken* cancellation);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_SEARCH_EXPOSURE_SEARCH_H_
