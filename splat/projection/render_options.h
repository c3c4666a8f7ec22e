// SPDX-License-Identifier: BSD-3-Clause
// What a view of a model depends on besides the model and the camera.

#ifndef FREEGS_SPLAT_PROJECTION_RENDER_OPTIONS_H_
#define FREEGS_SPLAT_PROJECTION_RENDER_OPTIONS_H_

#include <array>
#include <span>

#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

struct RenderOptions {
  // Colour behind the scene, linear in the image's own values, [0, 1].
  std::array<float, 3> background = {0, 0, 0};

  // SH degree to evaluate; the model's own degree when higher.
  int sh_degree = kMaxShDegree;

  // Gaussians nearer than this along the optical axis are skipped (world
  // units; the value of 3DGS).
  double near_plane = 0.2;

  // Radius in pixels of the low-pass filter added to each projected
  // covariance, as a variance (0.3 in 3DGS).
  double dilation = 0.3;
};

// Extra values per Gaussian to blend like colour: N x channels, row-major.
struct FeatureChannels {
  std::span<const float> values;
  int channels = 0;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_PROJECTION_RENDER_OPTIONS_H_
