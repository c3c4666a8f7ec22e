// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/local_contrast.h"

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

// Two halves of these colours; in the left one every second column is `stripe`.
ImageF Halves(float left, float stripe, float right) {
  ImageF lab(32, 32, 3);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) {
      lab(x, y, 0) = x >= 16 ? right : x % 2 == 0 ? left : stripe;
    }
  }
  return lab;
}

TEST(LocalContrastTest, StrongAcrossAnEdgeAndNothingWithin) {
  const ImageF lab = Halves(0.2f, 0.2f, 0.8f);
  const LocalContrast contrast(lab);
  const auto edge = contrast.Across(15, 16, true, 3);
  EXPECT_GT(edge.contrast, 0.95);
  EXPECT_NEAR(edge.difference, 0.6, 1e-6);
  EXPECT_NEAR(contrast.Across(8, 16, true, 3).contrast, 0, 1e-9);
  EXPECT_NEAR(contrast.Across(8, 16, false, 3).contrast, 0, 1e-9);
}

TEST(LocalContrastTest, TextureWeakensIt) {
  const LocalContrast plain(Halves(0.4f, 0.4f, 0.6f));
  const LocalContrast striped(Halves(0.1f, 0.7f, 0.6f));
  EXPECT_LT(striped.Across(15, 16, true, 8).contrast,
            0.5 * plain.Across(15, 16, true, 8).contrast);
}

TEST(LocalContrastTest, WindowsAreClippedAtTheBorder) {
  const LocalContrast contrast(Halves(0.2f, 0.2f, 0.8f));
  EXPECT_NEAR(contrast.Across(0, 0, true, 8).contrast, 0, 0.2);
  EXPECT_GE(contrast.Across(31, 31, false, 8).contrast, 0);
}

}  // namespace
}  // namespace freegs::semantics
