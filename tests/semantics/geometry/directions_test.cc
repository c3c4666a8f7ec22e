// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/geometry/directions.h"

#include <cmath>

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

TEST(DirectionsTest, LengthsDoNotCount) {
  std::vector<double> sum(2, 0.0);
  AddDirection(std::vector<float>{30, 40}, 2, sum);
  AddDirection(std::vector<float>{0, 0}, 5, sum);
  EXPECT_NEAR(sum[0], 1.2, 1e-12);
  EXPECT_NEAR(sum[1], 1.6, 1e-12);
  std::vector<float> out(2);
  WriteDirection(sum, out);
  EXPECT_NEAR(out[0], 0.6, 1e-7);
  EXPECT_NEAR(out[1], 0.8, 1e-7);
}

TEST(DirectionsTest, ZeroStaysZero) {
  std::vector<float> rows = {0, 0, 3, 4};
  MakeUnitRows(2, rows);
  EXPECT_EQ(rows[0], 0);
  EXPECT_NEAR(rows[3], 0.8, 1e-7);
  std::vector<float> out(2, 9);
  WriteDirection(std::vector<double>{0, 0}, out);
  EXPECT_EQ(out, (std::vector<float>{0, 0}));
}

TEST(DirectionsTest, MixesByShare) {
  const std::vector<float> a = {2, 0, 0, 0};
  const std::vector<float> b = {0, 5, 0, 1};
  EXPECT_EQ(MixDirections(a, b, 2, 1), (std::vector<float>{1, 0, 0, 0}));
  const std::vector<float> mixed = MixDirections(a, b, 2, 0.5);
  EXPECT_NEAR(mixed[0], std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(mixed[1], std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(mixed[3], 1, 1e-6);  // Of b alone, where a knows nothing.
}

}  // namespace
}  // namespace freegs::semantics
