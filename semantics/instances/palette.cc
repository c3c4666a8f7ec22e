// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/palette.h"

#include <algorithm>
#include <cmath>

namespace freegs::semantics {

std::array<uint8_t, 3> PaletteColor(int32_t label) {
  if (label < 0) return {56, 56, 56};
  constexpr double kGoldenRatio = 0.6180339887498949;
  constexpr std::array<std::array<double, 2>, 4> kTones = {
      {{0.75, 0.95}, {0.50, 1.00}, {0.90, 0.72}, {0.38, 0.80}}};
  const double hue = std::fmod(0.58 + kGoldenRatio * label, 1.0);
  const auto [saturation, value] = kTones[(label / 5) % kTones.size()];
  std::array<uint8_t, 3> color;
  for (int channel = 0; channel < 3; ++channel) {
    // HSV: each channel is a trapezoid of the hue, a third apart.
    const double x = std::fmod(hue * 6 + 5 - 2.0 * channel + 6, 6.0);
    const double ramp = std::clamp(std::min(x, 4 - x), 0.0, 1.0);
    color[channel] = static_cast<uint8_t>(
        std::lround(255 * value * (1 - saturation * ramp)));
  }
  return color;
}

}  // namespace freegs::semantics
