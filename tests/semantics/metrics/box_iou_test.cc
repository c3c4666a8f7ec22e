// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/metrics/box_iou.h"

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

TEST(AxisAlignedBoxIou, KnownOverlaps) {
  const AxisAlignedBox unit{{0, 0, 0}, {1, 1, 1}};
  const AxisAlignedBox shifted{{0.5, 0, 0}, {1.5, 1, 1}};
  const AxisAlignedBox away{{2, 0, 0}, {3, 1, 1}};
  const AxisAlignedBox touching{{1, 0, 0}, {2, 1, 1}};
  EXPECT_DOUBLE_EQ(BoxIou(unit, unit), 1);
  EXPECT_DOUBLE_EQ(BoxIou(unit, shifted), 1.0 / 3);
  EXPECT_DOUBLE_EQ(BoxIou(unit, away), 0);
  EXPECT_DOUBLE_EQ(BoxIou(unit, touching), 0);
}

TEST(AxisAlignedBoxIou, EmptyBoxesOverlapNothing) {
  const AxisAlignedBox unit{{0, 0, 0}, {1, 1, 1}};
  const AxisAlignedBox inverted{{1, 1, 1}, {0, 0, 0}};
  const AxisAlignedBox flat{{0, 0, 0}, {1, 1, 0}};
  EXPECT_EQ(BoxIou(unit, inverted), 0);
  EXPECT_EQ(BoxIou(unit, flat), 0);
  EXPECT_EQ(BoxIou(flat, flat), 0);
}

}  // namespace
}  // namespace freegs::semantics
