// SPDX-License-Identifier: BSD-3-Clause
// Turns rendered depth into 16-bit images and into colour previews.

#ifndef FREEGS_STAGES_SCENE_DEPTH_IMAGE_H_
#define FREEGS_STAGES_SCENE_DEPTH_IMAGE_H_

#include <span>

#include "core/image.h"
#include "core/pinhole.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::stages {

// The depths that a picture has to show, along the camera's z, in the unit of
// the picture.
struct DepthRange {
  double near = 0;
  double far = 1;
};

// The range of z in the camera frame over the centres of all Gaussians that
// project into the images of the views, in units of the model frame
// (splat/scene/model_frame.h). The nearest and the farthest 0.1 % are left out,
// because stray Gaussians can lie anywhere. The result is {0, 1} when no view
// sees a Gaussian.
DepthRange VisibleDepthRange(const splat::GaussianModel& model,
                             std::span<const View> views);

// The depth per step of a 16-bit image that has to reach `far`, in the unit of
// `far`. It is the smallest power of ten that is large enough: powers of ten
// let people read depths off the pixel values.
double DepthUnit(double far);

// round(depth / unit) per pixel, at least 1 and at most 65535, with both in the
// same unit. 0 means that nothing is there.
ImageU16 EncodeDepth(const ImageF& depth, double unit);

// A colour preview, H x W x 3 RGB: bright is near, dark is far, and black means
// that nothing is there. Brightness follows 1 / depth, so that near things of a
// deep scene still differ from each other.
ImageU8 ColorDepth(const ImageF& depth, const DepthRange& range);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_DEPTH_IMAGE_H_
