// SPDX-License-Identifier: BSD-3-Clause

#include "core/median.h"

#include <cstdint>

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

}  // namespace
}  // namespace freegs
