// SPDX-License-Identifier: BSD-3-Clause

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "splat/projection/simd_number-inl.h"

namespace freegs::splat::HWY_NAMESPACE {
namespace {

// The first lane.
float Value(SimdNumber number) {
  return hwy::HWY_NAMESPACE::GetLane(number.vector);
}

TEST(SimdNumber, ExpIsNearlyExact) {
  double worst = 0;
  for (float x = -87.0f; x <= 88.0f; x += 0.00137f) {
    const double expected = std::exp(double{x});
    worst =
        std::fmax(worst, std::abs(Value(exp(SimdNumber(x))) / expected - 1));
  }
  EXPECT_LT(worst, 3e-7);
}

TEST(SimdNumber, ExpStaysFiniteAndKeepsNan) {
  const float most = Value(exp(SimdNumber(88.0f)));
  const float least = Value(exp(SimdNumber(-87.0f)));
  EXPECT_TRUE(std::isfinite(most));
  EXPECT_TRUE(std::isfinite(1 / least));
  EXPECT_EQ(Value(exp(SimdNumber(1e30f))), most);
  EXPECT_EQ(Value(exp(SimdNumber(INFINITY))), most);
  EXPECT_EQ(Value(exp(SimdNumber(-1e30f))), least);
  EXPECT_EQ(Value(exp(SimdNumber(-INFINITY))), least);
  EXPECT_TRUE(std::isnan(Value(exp(SimdNumber(NAN)))));
}

TEST(SimdNumber, LogIsNearlyExact) {
  for (float x = std::numeric_limits<float>::min(); x < 3e38f; x *= 1.00037f) {
    const double expected = std::log(double{x});
    ASSERT_NEAR(Value(log(SimdNumber(x))), expected, 3e-7 * std::abs(expected))
        << x;
  }
  EXPECT_EQ(Value(log(SimdNumber(1.0f))), 0);
}

TEST(SimdNumber, Log1pIsNearlyExact) {
  for (float x = 1e-30f; x < 3e38f; x *= 1.00037f) {
    const double expected = std::log1p(double{x});
    ASSERT_NEAR(Value(log1p(SimdNumber(x))), expected, 6e-7 * expected) << x;
  }
  EXPECT_EQ(Value(log1p(SimdNumber(0.0f))), 0);
  EXPECT_TRUE(std::isnan(Value(log1p(SimdNumber(NAN)))));
}

}  // namespace
}  // namespace freegs::splat::HWY_NAMESPACE
