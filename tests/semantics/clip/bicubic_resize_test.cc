// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/bicubic_resize.h"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

using testing::ElementsAre;

ImageU8 Pattern(int width, int height) {
  ImageU8 image(width, height, 1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image(x, y) = static_cast<uint8_t>(x * 50 + y * 70);
    }
  }
  return image;
}

std::vector<int> Resized(const ImageU8& image, int width, int height) {
  const ImageU8 resized = ResizeBicubic(image, width, height);
  return {resized.data(), resized.data() + resized.size()};
}

// Numbers of Image.resize(..., Image.BICUBIC) of PIL 9.4.
TEST(BicubicResizeTest, IsThatOfPil) {
  EXPECT_THAT(Resized(Pattern(9, 7), 3, 2),
              ElementsAre(115, 132, 139, 121, 128, 130));
  EXPECT_EQ(Resized(Pattern(4, 3), 7, 5),
            (std::vector<int>{0,   8,   41,  70,  99,  132, 149, 20,  34,
                              67,  96,  126, 166, 188, 66,  83,  116, 145,
                              174, 207, 224, 114, 132, 165, 204, 215, 139,
                              93,  141, 158, 191, 237, 236, 90,  2}));
  EXPECT_EQ(Resized(Pattern(9, 3), 4, 6),
            (std::vector<int>{27,  151, 181, 92,  47,  152, 150, 115,
                              90,  156, 85,  164, 134, 145, 76,  178,
                              173, 120, 125, 156, 191, 108, 148, 145}));
}

TEST(BicubicResizeTest, SameSizeIsTheSame) {
  const ImageU8 image = Pattern(7, 5);
  EXPECT_EQ(Resized(image, 7, 5),
            std::vector<int>(image.data(), image.data() + image.size()));
}

TEST(BicubicResizeTest, AWindowIsAPartOfTheWhole) {
  ImageU8 image(23, 17, 3);
  for (size_t i = 0; i < image.size(); ++i) {
    image.data()[i] = static_cast<uint8_t>(i * i + 31 * i);
  }
  const ImageU8 whole = ResizeBicubic(image, 11, 29);
  const ImageU8 part = ResizeBicubic(image, 11, 29, {3, 20, 5, 9});
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 5; ++x) {
      for (int c = 0; c < 3; ++c) {
        ASSERT_EQ(part(x, y, c), whole(x + 3, y + 20, c));
      }
    }
  }
}

TEST(BicubicResizeTest, AWindowOfAnEnormousImageIsCheap) {
  const ImageU8 resized =
      ResizeBicubic(Pattern(1, 2), 200'000'000, 100'000'000, {99, 7, 2, 2});
  EXPECT_EQ(resized.width(), 2);
  EXPECT_EQ(resized(1, 1), 0);
}

}  // namespace
}  // namespace freegs::semantics
