// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/rate_limit.h"

#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

TEST(RateLimitTest, AllowsSoManyASecond) {
  RateLimit limit(2);
  EXPECT_TRUE(limit.Take(0));
  EXPECT_TRUE(limit.Take(0));
  EXPECT_FALSE(limit.Take(0));
  EXPECT_FALSE(limit.Take(0.25));
  EXPECT_TRUE(limit.Take(0.5));
  EXPECT_FALSE(limit.Take(0.5));
  EXPECT_TRUE(limit.Take(1));
}

TEST(RateLimitTest, APauseSavesUpOneSecond) {
  RateLimit limit(2);
  EXPECT_TRUE(limit.Take(100));
  EXPECT_TRUE(limit.Take(100));
  EXPECT_FALSE(limit.Take(100));
  EXPECT_TRUE(limit.Take(200));
  EXPECT_TRUE(limit.Take(200));
  EXPECT_FALSE(limit.Take(200));
}

TEST(RateLimitTest, TimeThatGoesBackAllowsNothing) {
  RateLimit limit(1);
  EXPECT_TRUE(limit.Take(10));
  EXPECT_FALSE(limit.Take(5));
  EXPECT_FALSE(limit.Take(10));
  EXPECT_TRUE(limit.Take(11));
}

}  // namespace
}  // namespace freegs::stages
