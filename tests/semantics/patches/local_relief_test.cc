// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/local_relief.h"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

constexpr double kNoise = 1e-3;

ImageF InverseDepths(const std::function<double(int, int)>& depth) {
  ImageF image(40, 40, 1);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) {
      image(x, y) = static_cast<float>(1 / depth(x, y));
    }
  }
  return image;
}

TEST(LocalReliefTest, TiltedPlanesHaveHardlyAnyStep) {
  // Depths of a plane: their inverse is linear in the image. With a focal
  // length of 400 pixels it is tilted by 63 degrees.
  const LocalRelief relief(InverseDepths([](int x, int y) {
                             return 1 / (0.18 + 1e-3 * x + 5e-4 * y);
                           }),
                           kNoise);
  for (const bool horizontal : {true, false}) {
    EXPECT_LT(relief.Step(20, 20, horizontal, 8), 0.01);
    EXPECT_LT(relief.Step(20, 20, horizontal, 4), 0.05);
  }
}

TEST(LocalReliefTest, AStepIsSeenOnlyWhereItIs) {
  const LocalRelief relief(
      InverseDepths([](int x, int) { return x < 20 ? 2.0 : 3.0; }), kNoise);
  EXPECT_GT(relief.Step(19, 20, true, 8), 0.99);
  EXPECT_GT(relief.Step(19, 20, true, 4), 0.99);
  EXPECT_LT(relief.Step(8, 20, true, 8), 1e-3);
  EXPECT_LT(relief.Step(30, 20, false, 8), 1e-3);
}

TEST(LocalReliefTest, ACreaseIsNoStep) {
  const LocalRelief relief(InverseDepths([](int x, int) {
                             return 1 / (0.5 + 1e-3 * std::abs(x - 20));
                           }),
                           kNoise);
  EXPECT_LT(relief.Step(19, 20, true, 8), 0.1);
}

TEST(LocalReliefTest, RoughSurfacesAndNoiseHideASmallStep) {
  const auto rough = [](double strength) {
    return [strength](int x, int y) {
      const int hair = (x * 7 + y * 13) % 5 - 2;
      return (x < 20 ? 2.0 : 2.1) + strength * hair;
    };
  };
  const double smooth =
      LocalRelief(InverseDepths(rough(0)), kNoise).Step(19, 20, true, 8);
  EXPECT_GT(smooth, 0.5);
  EXPECT_LT(
      LocalRelief(InverseDepths(rough(0.1)), kNoise).Step(19, 20, true, 8),
      0.5 * smooth);
  EXPECT_LT(LocalRelief(InverseDepths(rough(0)), 0.1).Step(19, 20, true, 8),
            0.2 * smooth);
}

TEST(LocalReliefTest, NothingIsKnownBesideHolesAndBorders) {
  ImageF inverse = InverseDepths([](int x, int) { return x < 20 ? 2 : 3; });
  for (int y = 0; y < 40; ++y) {
    for (int x = 20; x < 40; ++x) inverse(x, y) = 0;
  }
  const LocalRelief relief(inverse, kNoise);
  EXPECT_EQ(relief.Step(19, 20, true, 8), 0);
  EXPECT_EQ(relief.Step(0, 0, true, 8), 0);
  EXPECT_EQ(relief.Step(39, 39, false, 8), 0);
}

}  // namespace
}  // namespace freegs::semantics
