// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/union_space.h"

#include <algorithm>
#include <cmath>

#include "core/quantile.h"

namespace freegs::semantics {
namespace {

constexpr float kMaxRadii = 10;
constexpr double kQuantile = 0.005;

}  // namespace

Status UnionSpaceOptions::Check() const {
  for (const double weight : {position_weight, color_weight, semantic_weight}) {
    if (!(weight >= 0 && weight <= 1000)) {
      return InvalidArgumentError(
          "weights of the union space must lie in 0 .. 1000");
    }
  }
  return {};
}

std::vector<float> BuildUnionSpace(std::span<const float> positions,
                                   std::span<const float> colors,
                                   std::span<const float> semantics,
                                   int semantic_dim,
                                   const SceneExtent& extent,
                                   const UnionSpaceOptions& options) {
  const size_t count = positions.size() / 3;
  const size_t dim = 6 + static_cast<size_t>(semantic_dim);
  std::vector<float> points(count * dim);
  const auto position_weight = static_cast<float>(options.position_weight);
  const auto color_weight = static_cast<float>(options.color_weight);
  float low = 0;
  float scale = 0;
  if (semantic_dim > 0) {
    const std::vector<float> values(semantics.begin(), semantics.end());
    low = LowerQuantile(values, kQuantile);
    const double range = double{LowerQuantile(values, 1 - kQuantile)} - low;
    scale = range > 0 ? static_cast<float>(1 / range) : 0.0f;
  }
  for (size_t i = 0; i < count; ++i) {
    float* out = points.data() + i * dim;
    for (int k = 0; k < 3; ++k) {
      const auto x = static_cast<float>(
          (positions[i * 3 + k] - extent.centre[k]) / extent.radius);
      out[k] = position_weight * std::clamp(x, -kMaxRadii, kMaxRadii);
      out[3 + k] = color_weight * std::clamp(colors[i * 3 + k], 0.0f, 1.0f);
    }
    for (int k = 0; k < semantic_dim; ++k) {
      const float value = (semantics[i * semantic_dim + k] - low) * scale;
      out[6 + k] = static_cast<float>(options.semantic_weight) *
                   std::clamp(value, 0.0f, 1.0f);
    }
  }
  return points;
}

}  // namespace freegs::semantics
