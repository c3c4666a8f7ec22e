// SPDX-License-Identifier: BSD-3-Clause

#include "splat/scene/model_frame.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace freegs::splat {
namespace {

// Multiplies lengths by `scale`, then adds `shift` to positions.
void Move(double scale, const Eigen::Vector3d& shift, GaussianModel* model) {
  const double log_scale = std::log(scale);
  for (size_t k = 0; k < model->means.size(); ++k) {
    const auto axis = static_cast<Eigen::Index>(k % 3);
    model->means[k] =
        static_cast<float>(scale * double{model->means[k]} + shift[axis]);
    model->log_scales[k] =
        static_cast<float>(double{model->log_scales[k]} + log_scale);
  }
}

// The multiple of `step` that is nearest to x.
float Rounded(float x, double step) {
  return static_cast<float>(std::nearbyint(x / step) * step);
}

}  // namespace

void RoundToGrid(GaussianModel* model) {
  for (float& x : model->means) {
    // 19 binary digits, and 16 after the point at most.
    if (std::isfinite(x)) {
      x = Rounded(x, std::ldexp(1.0, std::max(std::ilogb(x), 2) - 18));
    }
  }
  for (float& x : model->log_scales) x = Rounded(x, std::ldexp(1.0, -14));
}

GaussianModel ToFrame(const PlacedModel& placed, const ModelFrame& frame) {
  GaussianModel model = placed.model;
  Move(1 / frame.unit, (placed.offset - frame.origin) / frame.unit, &model);
  RoundToGrid(&model);
  return model;
}

PlacedModel ToWorld(const GaussianModel& model, const ModelFrame& frame) {
  PlacedModel placed{model};
  if (frame.IsFarAway()) placed.offset = frame.origin;
  Move(frame.unit, frame.origin - placed.offset, &placed.model);
  return placed;
}

}  // namespace freegs::splat
