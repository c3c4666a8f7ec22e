// SPDX-License-Identifier: BSD-3-Clause

#include "stages/disturb/disturb_pixels.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "photos/photo_pixels.h"
#include "tests/photos/photo_test_files.h"

namespace freegs::stages {
namespace {

// A fine pattern left and right of an edge.
ImageU8 Picture(int width = 120, int height = 90) {
  ImageU8 picture(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int spot = (x / 2 + y / 2) % 2 == 0 ? 12 : -12;
      for (int c = 0; c < 3; ++c) {
        picture(x, y, c) =
            static_cast<uint8_t>((x < width / 2 ? 60 : 190) + spot);
      }
    }
  }
  return picture;
}

ImageU8 After(const std::string& text, PhotoTurn turn = {0.5, 7}) {
  ImageU8 picture = Picture();
  DisturbPixels(*ParseDisturbance(text), turn, &picture);
  return picture;
}

double Mean(const ImageU8& picture, int channel) {
  double sum = 0;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) sum += picture(x, y, channel);
  }
  return sum / static_cast<double>(picture.num_pixels());
}

double RootMeanSquareDifference(const ImageU8& a, const ImageU8& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    sum += std::pow(double{1} * a.data()[i] - b.data()[i], 2);
  }
  return std::sqrt(sum / static_cast<double>(a.size()));
}

bool Same(const ImageU8& a, const ImageU8& b) {
  return RootMeanSquareDifference(a, b) == 0;
}

TEST(DisturbPixelsTest, NoiseIsAsStrongAsAsked) {
  const ImageU8 noisy = After("noise:8");
  EXPECT_NEAR(RootMeanSquareDifference(noisy, Picture()), 8, 0.2);
  EXPECT_TRUE(Same(noisy, After("noise:8")));
  EXPECT_FALSE(Same(noisy, After("noise:8", {0.5, 8})));
  EXPECT_TRUE(Same(After("noise:0"), Picture()));
}

TEST(DisturbPixelsTest, BlurTakesSharpness) {
  EXPECT_TRUE(Same(After("blur:0"), Picture()));
  const double before = photos::Sharpness(Picture());
  const double weak = photos::Sharpness(After("blur:1"));
  EXPECT_LT(weak, before / 2);
  EXPECT_LT(photos::Sharpness(After("blur:3")), weak);
}

TEST(DisturbPixelsTest, LightDriftsOverThePhotographs) {
  const double before = Mean(Picture(), 0);
  EXPECT_LT(Mean(After("exposure:1", {0, 1}), 0), before - 10);
  EXPECT_GT(Mean(After("exposure:1", {1, 1}), 0), before + 10);
  EXPECT_TRUE(Same(After("exposure:1", {0.5, 1}), Picture()));
  const ImageU8 first = After("white_balance:1", {0, 1});
  EXPECT_LT(Mean(first, 0), before - 5);
  EXPECT_DOUBLE_EQ(Mean(first, 1), before);
  EXPECT_GT(Mean(first, 2), before + 5);
}

TEST(DisturbPixelsTest, AStopIsTwiceTheLight) {
  ImageU8 picture(1, 1, 3, 128);
  DisturbPixels({DisturbanceKind::kExposure, 2}, {1, 0}, &picture);
  // sRGB 128 is 0.2158 of the light; twice that is sRGB 176.
  EXPECT_EQ(picture(0, 0), 176);
}

TEST(DisturbPixelsTest, TextureFadesAndEdgesStay) {
  const ImageU8 plain = After("texture:1");
  EXPECT_TRUE(Same(After("texture:0"), Picture()));
  // Far from the edge the spots are nearly gone, and so is half of them with
  // half of the amount.
  const auto contrast = [](const ImageU8& picture) {
    return std::abs(picture(20, 40) - picture(22, 40));
  };
  EXPECT_EQ(contrast(Picture()), 24);
  EXPECT_LE(contrast(plain), 6);
  EXPECT_NEAR(contrast(After("texture:0.5")), 14, 2);
  EXPECT_GT(plain(70, 40) - plain(50, 40), 100);
}

TEST(DisturbPixelsTest, TheMoverIsSomewhereElseInEachPhotograph) {
  const ImageU8 a = After("mover:0.3", {0, 1});
  const ImageU8 b = After("mover:0.3", {0, 2});
  EXPECT_FALSE(Same(a, b));
  int changed = 0;
  const ImageU8 before = Picture();
  for (int y = 0; y < before.height(); ++y) {
    for (int x = 0; x < before.width(); ++x) {
      changed += a(x, y) != before(x, y) ? 1 : 0;
    }
  }
  // A disc 27 pixels wide.
  EXPECT_NEAR(changed, 3.14159 / 4 * 27 * 27, 60);
  EXPECT_FALSE(Same(After("mover:1"), before));
  EXPECT_TRUE(Same(After("mover:0"), before));
}

TEST(DisturbPixelsTest, OtherKindsChangeNoPixels) {
  for (const char* text : {"none", "drop:0.5", "focal:2", "jpeg:5"}) {
    EXPECT_TRUE(Same(After(text), Picture())) << text;
  }
}

}  // namespace
}  // namespace freegs::stages
