// SPDX-License-Identifier: BSD-3-Clause
// The settings of a rendering besides the model and the camera.

#ifndef FREEGS_SPLAT_PROJECTION_RENDER_OPTIONS_H_
#define FREEGS_SPLAT_PROJECTION_RENDER_OPTIONS_H_

#include <array>
#include <span>

#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

struct RenderOptions {
  // RGB behind the scene, in [0, 1] like the values of the image.
  std::array<float, 3> background = {0, 0, 0};

  // SH degree to evaluate; when the model has a lower degree, that one.
  int sh_degree = kMaxShDegree;

  // Gaussians whose centre is nearer than this along the optical axis are
  // skipped. Units of the model's frame (splat/scene/model_frame.h), in which
  // things are typically 5 away; 3DGS has the same value in world units.
  double near_plane = 0.2;

  // Variance in square pixels that is added to each projected covariance. It
  // acts as a low-pass filter against Gaussians thinner than a pixel; 3DGS has
  // the same value.
  double dilation = 0.3;
};

// Further values of every Gaussian that are blended like its colour: an
// N x channels matrix, row-major.
struct FeatureChannels {
  std::span<const float> values;
  int channels = 0;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_PROJECTION_RENDER_OPTIONS_H_
