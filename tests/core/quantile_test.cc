// SPDX-License-Identifier: BSD-3-Clause

#include "core/quantile.h"

#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace freegs {
namespace {

TEST(MedianTest, OddEvenAndEmpty) {
  EXPECT_EQ(Median({5, 1, 3}), 3);
  EXPECT_EQ(Median({4, 1, 8, 2}), 3);
  EXPECT_EQ(Median({7}), 7);
  EXPECT_EQ(Median({}), 0);
}

TEST(UpperMedianTest, IsOneOfTheValues) {
  EXPECT_EQ(UpperMedian<double>({5, 1, 3}), 3);
  EXPECT_EQ(UpperMedian<double>({4, 1, 8, 2}), 4);
  EXPECT_EQ(UpperMedian<int64_t>({3, 2}), 3);
  EXPECT_EQ(UpperMedian<double>({}), 0);
}

TEST(QuantileTest, EndsAndRanksBetween) {
  const std::vector<double> values = {40, 10, 30, 20};
  EXPECT_EQ(LowerQuantile(values, 0), 10);
  EXPECT_EQ(LowerQuantile(values, 1), 40);
  EXPECT_EQ(NearestQuantile(values, 0), 10);
  EXPECT_EQ(NearestQuantile(values, 1), 40);
  // Rank 0.9.
  EXPECT_EQ(LowerQuantile(values, 0.3), 10);
  EXPECT_EQ(NearestQuantile(values, 0.3), 20);
  // Rank 1.5: halves go up.
  EXPECT_EQ(LowerQuantile(values, 0.5), 20);
  EXPECT_EQ(NearestQuantile(values, 0.5), 30);
}

TEST(QuantileTest, OneValueAndNone) {
  EXPECT_EQ(LowerQuantile<float>({7}, 0.9), 7);
  EXPECT_EQ(NearestQuantile<float>({7}, 0.9), 7);
  EXPECT_EQ(LowerQuantile<float>({}, 0.9), 0);
  EXPECT_EQ(NearestQuantile<float>({}, 0.9), 0);
}

}  // namespace
}  // namespace freegs
