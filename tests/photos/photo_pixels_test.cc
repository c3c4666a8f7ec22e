// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_pixels.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/photos/photo_test_files.h"

namespace freegs::photos {
namespace {

TEST(PhotoPixelsTest, SharpnessFallsWithBlurAndIgnoresSize) {
  cv::Mat noise(300, 400, CV_8UC3);
  for (size_t i = 0; i < noise.total() * 3; ++i) {
    noise.data[i] = static_cast<uint8_t>(RandomIndex(1, 2, i, 256));
  }
  cv::Mat picture;
  cv::GaussianBlur(noise, picture, {}, 1.5);
  cv::Mat blurred;
  cv::GaussianBlur(picture, blurred, {}, 2.0);
  const double sharp = Sharpness(RgbOf(picture));
  EXPECT_GT(sharp, 2 * Sharpness(RgbOf(blurred)));
  EXPECT_EQ(Sharpness(RgbOf(cv::Mat(50, 50, CV_8UC3, cv::Scalar(7, 7, 7)))), 0);
  // Above 512 pixels the size makes little difference.
  cv::Mat large;
  cv::Mat larger;
  cv::resize(picture, large, {1024, 768}, 0, 0, cv::INTER_CUBIC);
  cv::resize(picture, larger, {2048, 1536}, 0, 0, cv::INTER_CUBIC);
  EXPECT_NEAR(Sharpness(RgbOf(larger)) / Sharpness(RgbOf(large)), 1, 0.05);
}

TEST(PhotoPixelsTest, ContentHashKnowsShape) {
  const ImageU8 wide(4, 2, 3, 5);
  const ImageU8 tall(2, 4, 3, 5);
  EXPECT_EQ(ContentHash(wide), ContentHash(ImageU8(4, 2, 3, 5)));
  EXPECT_NE(ContentHash(wide), ContentHash(tall));
  ImageU8 changed = wide;
  changed(3, 1, 2) = 6;
  EXPECT_NE(ContentHash(wide), ContentHash(changed));
}

}  // namespace
}  // namespace freegs::photos
