// SPDX-License-Identifier: BSD-3-Clause
// What a photograph and the model tell at each place of a view, however the
// surfaces are cut into patches.

#ifndef FREEGS_SEMANTICS_PATCHES_VIEW_CUES_H_
#define FREEGS_SEMANTICS_PATCHES_VIEW_CUES_H_

#include "core/image.h"
#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "semantics/patches/local_contrast.h"
#include "semantics/patches/local_relief.h"
#include "splat/scene/gaussian_model.h"
#include "splat/weights/blending_weights.h"

namespace freegs::semantics {

struct ViewCues {
  splat::WeightMatrix weights;
  View view;
  ImageF lab;  // See ToLab.
  LocalContrast contrast;
  LocalRelief relief;
  // Depths of the windows on both sides of a boundary, in pixels.
  int near_reach = 0;
  int far_reach = 0;
  int relief_reach = 0;
};

// photo: RGB in [0, 1]. baseline: how far apart the cameras stand, in units of
// the model frame. The weights must outlive the result, which only refers to
// them. kInvalidArgument unless weights, photo and the view's camera have the
// same size, and the weights are of this model.
StatusOr<ViewCues> FindViewCues(const splat::GaussianModel& model,
                                const splat::WeightMatrix& weights,
                                const View& view,
                                const ImageF& photo,
                                double baseline,
                                ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_VIEW_CUES_H_
