// SPDX-License-Identifier: BSD-3-Clause
// What stage reconstruct is going to need.

#ifndef FREEGS_STAGES_RECONSTRUCT_RECONSTRUCT_FORECAST_H_
#define FREEGS_STAGES_RECONSTRUCT_RECONSTRUCT_FORECAST_H_

#include <cstdint>

#include "pipeline/forecast/scene_outlook.h"
#include "pipeline/forecast/stage_need.h"
#include "splat/train/trainer.h"
#include "stages/reconstruct/reconstruct_options.h"

namespace freegs::stages {

// The most Gaussians that training is expected to have at any time, and those
// of the result, for so many points to begin with and so many pixels of the
// training photos.
struct ExpectedGaussians {
  double dense = 0;
  double left = 0;
};
ExpectedGaussians ExpectGaussians(const splat::TrainerOptions& training,
                                  int64_t points,
                                  int64_t train_pixels);

// The share of reconstruct.image_cache_gb that is for the holdout photos; the
// photos that are trained on have the rest. It follows from the pixels of both
// at the size of training, so that all photos fit when their sum does. Masks
// are taken to be as common in both: where only one kind has them, it may not
// fit though the sum does.
double HoldoutShareOfCache(int64_t train_pixels, int64_t holdout_pixels);

// The need for the photos and points of the scene. Also sets the number of its
// Gaussians to what is expected. With reconstruct.import that number must be
// set already, and is kept. Nothing is known without photos, points, or the
// imported Gaussians.
pipeline::StageNeed ReconstructNeed(const ReconstructStageOptions& options,
                                    const splat::TrainerOptions& training,
                                    int threads,
                                    pipeline::SceneOutlook* scene);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RECONSTRUCT_RECONSTRUCT_FORECAST_H_
