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
