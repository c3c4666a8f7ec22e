// SPDX-License-Identifier: BSD-3-Clause
// How many threads are worth starting.

#include "pipeline/system_info.h"

#include <cmath>

#include <gtest/gtest.h>

namespace freegs::pipeline {
namespace {

TEST(SystemInfoTest, AvailableCoresKeepToTheControlGroup) {
  EXPECT_GE(AvailableCores(), 1);
  EXPECT_LE(AvailableCores(), CoresOfAffinity());
  if (const auto quota = CoresOfQuota()) {
    EXPECT_LE(AvailableCores(), std::ceil(*quota));
  }
}

TEST(SystemInfoTest, AnOptionOfNoughtTakesTheAvailableCores) {
  EXPECT_EQ(WorkingThreads(0), AvailableCores());
  EXPECT_EQ(WorkingThreads(3), 3);
}

}  // namespace
}  // namespace freegs::pipeline
