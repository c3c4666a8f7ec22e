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

}  // namespace
}  // namespace freegs::semantics
