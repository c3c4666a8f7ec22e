// SPDX-License-Identifier: BSD-3-Clause

#include "splat/images/displacement.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::splat {
namespace {

// Smooth spots, moved to the right and down.
ImageF Picture(double dx, double dy, float brightness = 1) {
  ImageF picture(160, 120, 3);
  for (int spot = 0; spot < 60; ++spot) {
    const double cx = 160 * RandomUniform(1, 0, spot) + dx;
    const double cy = 120 * RandomUniform(1, 1, spot) + dy;
    for (int y = 0; y < 120; ++y) {
      for (int x = 0; x < 160; ++x) {
        const double r2 = std::pow(x - cx, 2) + std::pow(y - cy, 2);
        for (int c = 0; c < 3; ++c) {
          picture(x, y, c) +=
              brightness * static_cast<float>(0.4 * std::exp(-r2 / 18));
        }
      }
    }
  }
  return picture;
}

TEST(DisplacementTest, ShiftsAreMeasured) {
  const ImageF picture = Picture(0, 0);
  EXPECT_NEAR(Displacement(picture, picture), 0, 0.01);
  EXPECT_NEAR(Displacement(picture, Picture(3, -4)), 5, 0.3);
  EXPECT_NEAR(Displacement(picture, Picture(0.5, 0)), 0.5, 0.2);
  EXPECT_NEAR(Displacement(picture, Picture(10, 0)), 10, 0.5);
}

// A hand in front of the camera, on most of the picture and in the same place
// of both, would hide the shift.
TEST(DisplacementTest, WhatAMaskIgnoresDoesNotCount) {
  ImageF picture = Picture(0, 0);
  ImageF moved = Picture(3, -4);
  ImageU8 mask(160, 120, 1, 255);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 100; ++x) {
      mask(x, y) = 0;
      const auto value = static_cast<float>(RandomUniform(2, y, x));
      for (int c = 0; c < 3; ++c) picture(x, y, c) = moved(x, y, c) = value;
    }
  }
  EXPECT_LT(Displacement(picture, moved), 0.5);
  EXPECT_NEAR(Displacement(picture, moved, &mask), 5, 0.5);
}

TEST(DisplacementTest, ALineOfPixelsTellsNothing) {
  ImageF line(2, 1, 3, 0.0f);
  line(1, 0, 0) = 1;
  EXPECT_EQ(Displacement(line, ImageF(2, 1, 3, 0.5f)), 0);
  EXPECT_EQ(Displacement(line, line), 0);
}

TEST(DisplacementTest, BrightnessDoesNotMatter) {
  EXPECT_NEAR(Displacement(Picture(0, 0), Picture(3, 4, 0.3f)), 5, 0.3);
}

TEST(DisplacementTest, PlainPicturesLieWhereTheyShould) {
  const ImageF plain(160, 120, 3, 0.5f);
  EXPECT_EQ(Displacement(plain, plain), 0);
  EXPECT_EQ(Displacement(plain, Picture(0, 0)), 0);
}

}  // namespace
}  // namespace freegs::splat
