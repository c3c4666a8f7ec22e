// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/matching/edge_features.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace freegs::sfm {

bool IsInLastRow(double y, double scale, int height) {
  // COLMAP's octaves: the first has twice the photo's size, and each has three
  // scales. Positions between scales are refined by up to 1.5 steps, so that a
  // feature's scale fits one octave or two.
  constexpr int kFirstOctave = -1;
  constexpr double kSteps = 3;
  const double base = 1.6 * std::exp2(1 / kSteps);
  const double least = std::exp2(-1.5 / kSteps);
  const double most = std::exp2(3.5 / kSteps);
  constexpr double kTolerance = 0.01;     // Of scales, as a share.
  constexpr double kRowTolerance = 0.05;  // Of positions, in pixels.
  for (int octave = kFirstOctave; (height >> std::max(octave, 0)) > 0;
       ++octave) {
    const double pixel = std::exp2(octave);
    const double ratio = scale / (base * pixel);
    if (ratio < least * (1 - kTolerance) || ratio > most * (1 + kTolerance)) {
      continue;
    }
    const int rows = octave < 0 ? height << -octave : height >> octave;
    // The library's pixels have their centres at whole numbers.
    if (std::floor((y - 0.5) / pixel + 0.5 + kRowTolerance) >= rows - 1) {
      return true;
    }
  }
  return false;
}

void ClearUnsetDescriptors(const std::vector<FeaturePlace>& features,
                           int photo_width,
                           int photo_height,
                           int max_image_size,
                           SiftDescriptors* descriptors) {
  if (features.size() != descriptors->count() || photo_height <= 0) return;
  const int longest = std::max(photo_width, photo_height);
  const double shrink = longest > max_image_size && max_image_size > 0
                            ? static_cast<double>(max_image_size) / longest
                            : 1.0;
  // COLMAP rounds down.
  const int height = static_cast<int>(photo_height * shrink);
  const double factor = static_cast<double>(height) / photo_height;
  for (size_t i = 0; i < features.size(); ++i) {
    if (!IsInLastRow(
            features[i].y * factor, features[i].scale * factor, height)) {
      continue;
    }
    std::fill_n(descriptors->values.begin() +
                    static_cast<std::ptrdiff_t>(i * kSiftDimensions),
                kSiftDimensions,
                uint8_t{0});
  }
}

}  // namespace freegs::sfm
