// SPDX-License-Identifier: BSD-3-Clause
// Depth as 16-bit and as colour images.

#ifndef FREEGS_STAGES_SCENE_DEPTH_IMAGE_H_
#define FREEGS_STAGES_SCENE_DEPTH_IMAGE_H_

#include <span>

#include "core/image.h"
#include "core/pinhole.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::stages {

// Nearest and farthest depth that matter, world units.
struct DepthRange {
  double near = 0;
  double far = 1;
};

// The range of z in the camera frame over the Gaussians' centres that lie in
// the images of the views, without the nearest and farthest 1 in 1000 (stray
// Gaussians can be anywhere). {0, 1} when no view sees any.
DepthRange VisibleDepthRange(const splat::GaussianModel& model,
                             std::span<const View> views);

// World units per step of a 16-bit image that reaches `far`: the smallest power
// of ten that is enough, so that a value is readable without a calculator.
double DepthUnit(double far);

// round(depth / unit); 0 where depth is 0, 65535 where it is farther.
ImageU16 EncodeDepth(const ImageF& depth, double unit);

// A colour preview: bright is near, dark is far, black is nothing. Scaled by
// 1 / depth, which spreads the near part of a deep scene.
ImageU8 ColorDepth(const ImageF& depth, const DepthRange& range);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_DEPTH_IMAGE_H_
