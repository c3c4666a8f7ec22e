// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/scene/reconstruction_measures.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::sfm {
namespace {

TEST(TriangulationAngleDeg, KnownAngles) {
  EXPECT_NEAR(
      TriangulationAngleDeg({0, 0, 0}, {{1, 0, 0}, {0, 5, 0}}), 90, 1e-12);
  EXPECT_NEAR(
      TriangulationAngleDeg({0, 0, 0}, {{1, 0, 0}, {1, 0.01, 0}, {-1, 1, 0}}),
      135,
      1e-9);
  EXPECT_NEAR(TriangulationAngleDeg({0, 0, 0}, {{1, 0, 0}, {1e3, 1e-2, 0}}),
              1e-5 * 180 / M_PI,
              1e-9);
  EXPECT_EQ(TriangulationAngleDeg({0, 0, 0}, {{1, 0, 0}}), 0);
  EXPECT_EQ(TriangulationAngleDeg({0, 0, 0}, {{0, 0, 0}, {0, 0, 0}}), 0);
}

// Rays on a cone of 20 degrees around z: comparing all pairs of a track that
// somebody made up would take minutes.
TEST(TriangulationAngleDeg, LongTracksTakeNoLonger) {
  std::vector<Eigen::Vector3d> centres;
  constexpr int kCount = 200'000;
  for (int i = 0; i < kCount; ++i) {
    const double turn = 2 * M_PI * i / kCount;
    centres.emplace_back(std::sin(M_PI / 9) * std::cos(turn),
                         std::sin(M_PI / 9) * std::sin(turn),
                         std::cos(M_PI / 9));
  }
  EXPECT_NEAR(TriangulationAngleDeg({0, 0, 0}, centres), 40, 0.01);
}

TEST(TriangulationAngleDeg, EvenlySpreadRaysStandForALongTrack) {
  RandomStream random(3, 1);
  std::vector<Eigen::Vector3d> centres;
  std::vector<Eigen::Vector3d> fourths;
  for (int i = 0; i < 1024; ++i) {
    centres.emplace_back(random.Uniform(), random.Uniform(), 5);
    if (i % 4 == 0) fourths.push_back(centres.back());
  }
  // The two centres that are farthest apart are none of these.
  centres[1] = {-1, -1, 5};
  centres[1022] = {2, 2, 5};
  EXPECT_EQ(TriangulationAngleDeg({0, 0, 0}, centres),
            TriangulationAngleDeg({0, 0, 0}, fourths));
}

}  // namespace
}  // namespace freegs::sfm
