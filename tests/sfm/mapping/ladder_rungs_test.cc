// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/mapping/ladder_rungs.h"

#include <gtest/gtest.h>

namespace freegs::sfm {
namespace {

TEST(LargerImageSizeTest, GrowsByHalfAndUpTo1600ByMore) {
  EXPECT_EQ(LargerImageSize(400), 800);
  EXPECT_EQ(LargerImageSize(800), 1600);
  EXPECT_EQ(LargerImageSize(1000), 1600);
  EXPECT_EQ(LargerImageSize(1200), 1800);
  EXPECT_EQ(LargerImageSize(1600), 2400);
}

}  // namespace
}  // namespace freegs::sfm
