// SPDX-License-Identifier: BSD-3-Clause
// How large images must be.

#include "sfm/features/image_size.h"

#include <gtest/gtest.h>

namespace freegs::sfm {
namespace {

TEST(ImageSizeFor, SmallestThatIsEnough) {
  EXPECT_EQ(ImageSizeFor(100000, 3000), 800);
  EXPECT_EQ(ImageSizeFor(2400, 3000), 800);
  EXPECT_EQ(ImageSizeFor(2300, 3000), 900);
  EXPECT_EQ(ImageSizeFor(1000, 3000), 1600);
  for (const int64_t found : {-1, 0, 1}) {
    EXPECT_EQ(ImageSizeFor(found, 3000), 1600);
  }
  EXPECT_EQ(ImageSizeFor(2500, 8192), 1600);
}

}  // namespace
}  // namespace freegs::sfm
