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

TEST(NumSharedTest, CountsNames) {
  Reconstruction a;
  Reconstruction b;
  for (const char* name : {"1.jpg", "2.jpg", "3.jpg"}) {
    a.images.emplace_back().name = name;
  }
  for (const char* name : {"3.jpg", "4.jpg", "1.jpg", "5.jpg"}) {
    b.images.emplace_back().name = name;
  }
  EXPECT_EQ(NumShared(a, b), 2u);
  EXPECT_EQ(NumShared(b, a), 2u);
  EXPECT_EQ(NumShared(a, {}), 0u);
}

}  // namespace
}  // namespace freegs::sfm
