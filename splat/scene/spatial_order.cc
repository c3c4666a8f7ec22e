// SPDX-License-Identifier: BSD-3-Clause

#include "splat/scene/spatial_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace freegs::splat {
namespace {

constexpr int kBitsPerAxis = 10;
constexpr double kTrimmedShare = 0.02;

struct Range {
  float low = 0;
  float high = 0;
};

// The range of the finite values of one axis without the lowest and the highest
// 2 %.
Range MiddleRange(const GaussianModel& model, size_t axis) {
  std::vector<float> values;
  values.reserve(model.size());
  for (size_t i = 0; i < model.size(); ++i) {
    const float value = model.means[3 * i + axis];
    if (std::isfinite(value)) values.push_back(value);
  }
  if (values.empty()) return {};
  const auto trimmed = static_cast<ptrdiff_t>(
      kTrimmedShare * static_cast<double>(values.size()));
  const auto low = values.begin() + trimmed;
  const auto high = values.end() - 1 - trimmed;
  std::nth_element(values.begin(), low, values.end());
  const float low_value = *low;
  std::nth_element(values.begin(), high, values.end());
  return {low_value, *high};
}

// Bit b of the value becomes bit 3 b.
uint32_t SpreadBits(uint32_t value) {
  value = (value | value << 16) & 0x030000ff;
  value = (value | value << 8) & 0x0300f00f;
  value = (value | value << 4) & 0x030c30c3;
  return (value | value << 2) & 0x09249249;
}

}  // namespace

std::vector<uint32_t> MortonOrder(const GaussianModel& model) {
  std::array<Range, 3> ranges;
  for (size_t axis = 0; axis < 3; ++axis) {
    ranges[axis] = MiddleRange(model, axis);
  }
  constexpr float kCells = 1 << kBitsPerAxis;
  std::vector<std::pair<uint32_t, uint32_t>> keys(model.size());
  for (size_t i = 0; i < keys.size(); ++i) {
    uint32_t code = 0;
    for (size_t axis = 0; axis < 3; ++axis) {
      const Range& range = ranges[axis];
      const float width = range.high - range.low;
      float cell =
          width > 0 ? (model.means[3 * i + axis] - range.low) * (kCells / width)
                    : 0.0f;
      if (!(cell > 0)) cell = 0;  // Also where the mean is not finite.
      if (cell > kCells - 1) cell = kCells - 1;
      code |= SpreadBits(static_cast<uint32_t>(cell)) << axis;
    }
    keys[i] = {code, static_cast<uint32_t>(i)};
  }
  std::sort(keys.begin(), keys.end());
  std::vector<uint32_t> order(keys.size());
  for (size_t k = 0; k < keys.size(); ++k) order[k] = keys[k].second;
  return order;
}

}  // namespace freegs::splat
