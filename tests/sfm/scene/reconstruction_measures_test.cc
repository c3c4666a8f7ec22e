// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/scene/reconstruction_measures.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace freegs::sfm
