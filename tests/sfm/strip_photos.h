// SPDX-License-Identifier: BSD-3-Clause
// Photos without pixels: SIFT-like descriptors of a strip of wall, of which
// each photo sees a window.

#ifndef FREEGS_TESTS_SFM_STRIP_PHOTOS_H_
#define FREEGS_TESTS_SFM_STRIP_PHOTOS_H_

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/random.h"
#include "sfm/matching/global_descriptor.h"

namespace freegs::sfm {

inline constexpr int kStripFeatures = 200;  // Features of each photo.

// Feature `index` of the wall, seen by one of many photos: a vector of length
// about 512 with some noise.
inline void AppendStripFeature(int64_t index,
                               uint64_t photo,
                               SiftDescriptors* descriptors) {
  double values[kSiftDimensions];
  double squared = 0;
  for (size_t k = 0; k < kSiftDimensions; ++k) {
    const double wall = RandomUniform(1, index, k);
    const double noise = RandomNormal(2 + photo, index, k);
    values[k] = std::max(0.0, wall * wall + 0.05 * noise);
    squared += values[k] * values[k];
  }
  const double scale = 512 / std::sqrt(squared);
  for (const double value : values) {
    descriptors->values.push_back(
        static_cast<uint8_t>(std::min(255.0, std::round(value * scale))));
  }
}

// Photo k sees the window that begins at positions[k] photo widths.
inline std::vector<SiftDescriptors> StripPhotos(
    const std::vector<double>& positions) {
  std::vector<SiftDescriptors> photos(positions.size());
  for (size_t i = 0; i < positions.size(); ++i) {
    const auto first =
        static_cast<int64_t>(std::round(positions[i] * kStripFeatures));
    for (int k = 0; k < kStripFeatures; ++k) {
      AppendStripFeature(first + k, i, &photos[i]);
    }
  }
  return photos;
}

inline std::vector<PhotoFeatures> AllFeatures(
    const std::vector<SiftDescriptors>& photos) {
  std::vector<PhotoFeatures> features;
  for (const SiftDescriptors& photo : photos) features.push_back({&photo, {}});
  return features;
}

}  // namespace freegs::sfm

#endif  // FREEGS_TESTS_SFM_STRIP_PHOTOS_H_
