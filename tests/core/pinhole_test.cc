// SPDX-License-Identifier: BSD-3-Clause

#include "core/pinhole.h"

#include <gtest/gtest.h>

namespace freegs {
namespace {

TEST(PinholeTest, ResizingKeepsDirections) {
  const Pinhole camera{1080, 1920, 1400, 1410, 540.5, 955};
  const Pinhole half = camera.Resized(540, 960);
  // The pixel position of a direction scales with the image, since pixel
  // centres are at +0.5.
  const double u = camera.fx * 0.3 + camera.cx;
  const double v = camera.fy * -0.2 + camera.cy;
  EXPECT_DOUBLE_EQ(half.fx * 0.3 + half.cx, u / 2);
  EXPECT_DOUBLE_EQ(half.fy * -0.2 + half.cy, v / 2);
}

TEST(PinholeTest, LimitConcernsTheLongestSide) {
  const Pinhole camera{1080, 1920, 1400, 1410, 540, 960};
  const Pinhole small = camera.LimitedTo(480);
  EXPECT_EQ(small.height, 480);
  EXPECT_EQ(small.width, 270);
  EXPECT_EQ(camera.LimitedTo(0).width, 1080);
  EXPECT_EQ(camera.LimitedTo(5000).width, 1080);
  const Pinhole sliver{10000, 3, 100, 100, 5000, 1.5};
  EXPECT_EQ(sliver.LimitedTo(100).height, 1);
}

}  // namespace
}  // namespace freegs
