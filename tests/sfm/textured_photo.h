// SPDX-License-Identifier: BSD-3-Clause
// A small photo with many features.

#ifndef FREEGS_TESTS_SFM_TEXTURED_PHOTO_H_
#define FREEGS_TESTS_SFM_TEXTURED_PHOTO_H_

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>

#include <gtest/gtest.h>

#include "core/image.h"
#include "core/io/image_io.h"
#include "core/random.h"
#include "sfm/colmap/sfm_options.h"

namespace freegs::sfm {

// Adds a grey blob to an image: a Gaussian of the given standard deviation and
// height, around (x, y) in pixels from the image's corner.
inline void AddBlob(
    double x, double y, double sigma, double height, ImageU8* image) {
  const double reach = 4 * sigma;
  const int first_y = std::max(0, static_cast<int>(y - reach));
  const int first_x = std::max(0, static_cast<int>(x - reach));
  const int last_y = std::min(image->height() - 1, static_cast<int>(y + reach));
  const int last_x = std::min(image->width() - 1, static_cast<int>(x + reach));
  for (int v = first_y; v <= last_y; ++v) {
    for (int u = first_x; u <= last_x; ++u) {
      const double squared =
          (u + 0.5 - x) * (u + 0.5 - x) + (v + 0.5 - y) * (v + 0.5 - y);
      const double add = height * std::exp(-0.5 * squared / (sigma * sigma));
      for (int c = 0; c < image->channels(); ++c) {
        uint8_t& value = (*image)(u, v, c);
        value = static_cast<uint8_t>(std::clamp(value + add, 0.0, 255.0));
      }
    }
  }
}

// A grey photo with blobs at random places, which are the same for the same
// seed.
inline ImageU8 TexturedPhoto(int width, int height, uint64_t seed) {
  ImageU8 image(width, height, 3, 100);
  const int blobs = width * height / 300;
  for (int k = 0; k < blobs; ++k) {
    AddBlob(width * RandomUniform(seed, k, 0),
            height * RandomUniform(seed, k, 1),
            1.5 + 3 * RandomUniform(seed, k, 2),
            120 * RandomUniform(seed, k, 3) - 60,
            &image);
  }
  return image;
}

// Writes the same small photo under the names of all photos.
inline void WriteTexturedPhotos(const SfmInput& input) {
  const ImageU8 image = TexturedPhoto(160, 120, 1);
  for (const SfmPhoto& photo : input.photos) {
    const std::filesystem::path path = input.photo_folder / photo.name;
    std::filesystem::create_directories(path.parent_path());
    EXPECT_TRUE(WriteImage(path, image).ok());
  }
}

}  // namespace freegs::sfm

#endif  // FREEGS_TESTS_SFM_TEXTURED_PHOTO_H_
