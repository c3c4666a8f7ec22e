// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/semantic_colors.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include "semantics/geometry/principal_axes.h"

namespace freegs::semantics {
namespace {

constexpr size_t kColors = 3;
// Share of the vectors at each end of a channel's range that are cut to it, so
// that a few strays do not squash all others.
constexpr double kTrim = 0.02;

// The directions of the vectors that are not zero.
struct Directions {
  std::vector<float> rows;
  std::vector<size_t> indices;  // Which vector each row belongs to.
};

Directions NonZeroDirections(std::span<const float> features, size_t dim) {
  Directions directions;
  directions.rows.reserve(features.size());
  for (size_t i = 0; i < features.size() / dim; ++i) {
    const std::span<const float> row = features.subspan(i * dim, dim);
    double square = 0;
    for (const float value : row) square += static_cast<double>(value) * value;
    if (square == 0) continue;
    directions.indices.push_back(i);
    for (const float value : row) {
      directions.rows.push_back(static_cast<float>(value / std::sqrt(square)));
    }
  }
  return directions;
}

// Maps one channel of `coordinates` (rows of `stride`) onto [0, 1].
void Stretch(size_t channel, size_t stride, std::vector<float>* coordinates) {
  std::vector<float> sorted;
  for (size_t k = channel; k < coordinates->size(); k += stride) {
    sorted.push_back((*coordinates)[k]);
  }
  std::sort(sorted.begin(), sorted.end());
  const auto spare =
      static_cast<size_t>(kTrim * static_cast<double>(sorted.size() - 1));
  const float low = sorted[spare];
  const float range = sorted[sorted.size() - 1 - spare] - low;
  // A smaller range is rounding, since directions have length 1.
  constexpr float kNoRange = 1e-6f;
  for (size_t k = channel; k < coordinates->size(); k += stride) {
    float& value = (*coordinates)[k];
    value =
        range > kNoRange ? std::clamp((value - low) / range, 0.0f, 1.0f) : 0.5f;
  }
}

}  // namespace

StatusOr<std::vector<float>> SemanticColors(std::span<const float> features,
                                            int dim,
                                            ThreadPool& pool) {
  if (dim < 1 || features.size() % static_cast<size_t>(dim) != 0) {
    return InvalidArgumentError(std::to_string(features.size()) +
                                " numbers are no semantic vectors of " +
                                std::to_string(dim));
  }
  const auto size = static_cast<size_t>(dim);
  std::vector<float> colors(features.size() / size * kColors);
  const Directions directions = NonZeroDirections(features, size);
  if (directions.indices.empty()) return colors;

  FREEGS_ASSIGN_OR_RETURN(
      PrincipalAxes axes,
      ComputePrincipalAxes(directions.rows, dim, /*about_mean=*/true, pool));
  const size_t channels = std::min(kColors, size);
  axes.Keep(static_cast<int>(channels));
  std::vector<float> coordinates = ProjectOntoAxes(axes, directions.rows, pool);
  for (size_t c = 0; c < channels; ++c) {
    Stretch(c, channels, &coordinates);
  }
  for (size_t r = 0; r < directions.indices.size(); ++r) {
    float* color = &colors[directions.indices[r] * kColors];
    std::fill_n(color, kColors, 0.5f);
    std::copy_n(&coordinates[r * channels], channels, color);
  }
  return colors;
}

}  // namespace freegs::semantics
