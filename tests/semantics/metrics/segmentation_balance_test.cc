// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/metrics/segmentation_balance.h"

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

TEST(SegmentationBalance, OneInstancePerObject) {
  InstanceOverlap overlap;
  overlap.truth_pixels = {{1, 100}, {2, 300}};
  overlap.instance_pixels = {{0, 110}, {5, 300}};
  overlap.shared_pixels = {{{1, 0}, 95}, {{1, 5}, 5}, {{2, 5}, 295}};
  const SegmentationBalance balance = MeasureSegmentationBalance(overlap);
  EXPECT_EQ(balance.pieces, (std::map<int, int>{{1, 1}, {2, 1}}));
  EXPECT_DOUBLE_EQ(*balance.instances_per_object, 1);
  EXPECT_DOUBLE_EQ(*balance.objects_per_instance, 1);
  EXPECT_EQ(balance.num_instances, 2);
  EXPECT_EQ(balance.num_crumbs, 0);
  EXPECT_NEAR(*balance.uncovered, 5 / 400.0, 1e-12);
}

TEST(SegmentationBalance, TooFineAndTooCoarse) {
  InstanceOverlap overlap;
  // Object 1 lies in three pieces; 2 and 3 are one instance with the floor.
  // Nothing covers object 4.
  overlap.truth_pixels = {{1, 100}, {2, 50}, {3, 50}, {4, 10}};
  overlap.instance_pixels = {{0, 60}, {1, 30}, {2, 10}, {3, 5000}, {4, 4}};
  overlap.shared_pixels = {
      {{1, 0}, 60}, {{1, 1}, 30}, {{1, 2}, 10}, {{2, 3}, 50}, {{3, 3}, 26}};
  const SegmentationBalance balance = MeasureSegmentationBalance(overlap);
  EXPECT_EQ(balance.pieces,
            (std::map<int, int>{{1, 3}, {2, 1}, {3, 1}, {4, 0}}));
  EXPECT_DOUBLE_EQ(*balance.instances_per_object, 5 / 3.0);
  // Instance 0 covers more than half of one object, instance 3 of two.
  EXPECT_DOUBLE_EQ(*balance.objects_per_instance, 1.5);
  EXPECT_EQ(balance.num_instances, 5);
  EXPECT_EQ(balance.num_crumbs, 1);
  EXPECT_NEAR(*balance.uncovered, 34 / 210.0, 1e-12);
}

TEST(SegmentationBalance, NothingThere) {
  const SegmentationBalance none = MeasureSegmentationBalance({});
  EXPECT_FALSE(none.instances_per_object);
  EXPECT_FALSE(none.objects_per_instance);
  EXPECT_FALSE(none.uncovered);
  EXPECT_EQ(none.num_instances, 0);

  InstanceOverlap unseen;
  unseen.truth_pixels = {{1, 10}};
  EXPECT_FALSE(MeasureSegmentationBalance(unseen).instances_per_object);
  EXPECT_DOUBLE_EQ(*MeasureSegmentationBalance(unseen).uncovered, 1);
}

}  // namespace
}  // namespace freegs::semantics
