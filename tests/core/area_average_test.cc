// SPDX-License-Identifier: BSD-3-Clause

#include "core/area_average.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include <gtest/gtest.h>

#include "core/io/image_io.h"
#include "core/random.h"

namespace freegs {
namespace {

ImageU8 RandomPixels(int width, int height, int channels) {
  ImageU8 image(width, height, channels);
  for (size_t i = 0; i < image.size(); ++i) {
    image.data()[i] = static_cast<uint8_t>(256 * RandomUniform(5, 0, i));
  }
  return image;
}

// The mean over the area of each pixel, in double.
double Mean(const ImageU8& image, int width, int height, int x, int y, int c) {
  const double wide = 1.0 * image.width() / width;
  const double high = 1.0 * image.height() / height;
  double sum = 0;
  for (int v = 0; v < image.height(); ++v) {
    const double rows =
        std::min(v + 1.0, (y + 1) * high) - std::max(1.0 * v, y * high);
    for (int u = 0; u < image.width() && rows > 0; ++u) {
      const double columns =
          std::min(u + 1.0, (x + 1) * wide) - std::max(1.0 * u, x * wide);
      if (columns > 0) sum += rows * columns * image(u, v, c);
    }
  }
  return sum / (wide * high);
}

TEST(AreaAverage, IsTheMeanOfWhatAPixelCovers) {
  const ImageU8 image = RandomPixels(37, 23, 3);
  for (const auto& [width, height] : {std::pair(37, 23),
                                      {36, 22},
                                      {19, 12},
                                      {12, 23},
                                      {7, 3},
                                      {1, 1},
                                      {50, 40}}) {
    const ImageU8 small = AreaAverage(image, width, height);
    ASSERT_EQ(small.width(), width);
    ASSERT_EQ(small.height(), height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        for (int c = 0; c < 3; ++c) {
          ASSERT_NEAR(
              small(x, y, c), Mean(image, width, height, x, y, c), 0.5 + 1e-9);
        }
      }
    }
  }
}

TEST(AreaAverage, ExtremesStay) {
  ImageU8 image(50, 40, 1);
  std::fill_n(image.data(), image.size(), uint8_t{255});
  const ImageU8 white = AreaAverage(image, 13, 7);
  for (size_t i = 0; i < white.size(); ++i) EXPECT_EQ(white.data()[i], 255);
}

TEST(AreaAverage, IsThatOfOpenCvButForRounding) {
  const ImageU8 image = RandomPixels(320, 180, 3);
  const ImageU8 small = AreaAverage(image, 123, 69);
  const ImageU8 other = Resize(image, 123, 69);
  for (size_t i = 0; i < small.size(); ++i) {
    ASSERT_NEAR(small.data()[i], other.data()[i], 1);
  }
}

}  // namespace
}  // namespace freegs
