// SPDX-License-Identifier: BSD-3-Clause

#include "bench/evidence/segmentation_quality.h"

#include <map>
#include <vector>

#include <gtest/gtest.h>

namespace freegs::evidence {
namespace {

// Two objects. Patch 0 is in object 1, patch 2 in object 2, and patch 1 in
// both. No patch has the last 40 pixels of each. Patch 3 is a surface of the
// room, and object 3 is too small to be judged.
LearningScene TwoObjects() {
  LearningScene scene;
  scene.pixels = {300, 100, 200, 400};
  scene.votes = {
      {{1, 300}}, {{1, 60}, {2, 40}}, {{2, 200}}, {{kFirstSurface, 400}}};
  scene.segment_pixels = {{1, 400}, {2, 280}, {3, 50}, {kFirstSurface, 400}};
  return scene;
}

// The IoU of patch 0, and of patches 0 and 1 together, with object 1, and that
// of patch 2 with object 2.
constexpr double kIouOfPatch0 = 300.0 / 400;
constexpr double kIouOfPatches01 = 360.0 / (400 + 400 - 360);
constexpr double kIouOfPatch2 = 200.0 / 280;

TEST(SegmentationQualityTest, EachObjectHasTheRegionThatMeetsItBest) {
  const std::vector<ObjectQuality> objects =
      MeasureObjects(TwoObjects(), {7, 7, 4, -1});
  ASSERT_EQ(objects.size(), 2u);
  EXPECT_EQ(objects[0].id, 1);
  EXPECT_EQ(objects[0].pixels, 400);
  EXPECT_EQ(objects[0].region, 7);
  EXPECT_NEAR(objects[0].iou, kIouOfPatches01, 1e-12);
  EXPECT_EQ(objects[0].pieces, 1);
  EXPECT_EQ(objects[0].in_region, (std::map<int, double>{{1, 360}, {2, 40}}));
  EXPECT_EQ(objects[1].id, 2);
  EXPECT_EQ(objects[1].region, 4);
  EXPECT_NEAR(objects[1].iou, kIouOfPatch2, 1e-12);
  EXPECT_EQ(objects[1].pieces, 2);  // A seventh of it is in region 7.
  EXPECT_NEAR(MeanIou(objects), (kIouOfPatches01 + kIouOfPatch2) / 2, 1e-12);
  EXPECT_EQ(MeanPieces(objects), 1.5);
}

TEST(SegmentationQualityTest, WhatNoRegionMeetsIsWorthNothing) {
  const std::vector<ObjectQuality> objects =
      MeasureObjects(TwoObjects(), {-1, -1, -1, 0});
  ASSERT_EQ(objects.size(), 2u);
  for (const ObjectQuality& object : objects) {
    EXPECT_EQ(object.region, -1);
    EXPECT_EQ(object.iou, 0);
    EXPECT_EQ(object.pieces, 0);
  }
  EXPECT_EQ(MeanIou(objects), 0);
  EXPECT_EQ(MeanIou({}), 0);
  EXPECT_EQ(MeanPieces({}), 0);
  EXPECT_EQ(BestPatchesIou(LearningScene()), 0);
}

TEST(SegmentationQualityTest, TheBestLevelAndTheBestPatchesAreUpperBounds) {
  const LearningScene scene = TwoObjects();
  const semantics::RegionTree good = {
      .num_leaves = 4, .merges = {{0, 1, -1}, {4, 2, 0}, {5, 3, 1}}};
  EXPECT_NEAR(
      BestLevelIou(scene, good), (kIouOfPatches01 + kIouOfPatch2) / 2, 1e-12);
  // No region has patches 0 and 1 alone, so patch 0 is the best of object 1.
  const semantics::RegionTree bad = {
      .num_leaves = 4, .merges = {{0, 2, -1}, {4, 1, 0}, {5, 3, 1}}};
  EXPECT_NEAR(
      BestLevelIou(scene, bad), (kIouOfPatch0 + kIouOfPatch2) / 2, 1e-12);
  EXPECT_NEAR(
      BestPatchesIou(scene), (kIouOfPatches01 + kIouOfPatch2) / 2, 1e-12);
}

}  // namespace
}  // namespace freegs::evidence
