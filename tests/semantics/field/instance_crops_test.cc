// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/instance_crops.h"

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

// 20 x 10: label 4 in [5, 11) x [2, 6), label 0 at the left border.
Image<int32_t> Labels() {
  Image<int32_t> labels(20, 10, 1, -1);
  for (int y = 2; y < 6; ++y) {
    for (int x = 5; x < 11; ++x) labels(x, y) = 4;
    labels(0, y) = 0;
  }
  return labels;
}

TEST(InstanceCropsTest, CutsASquareAroundTheInstance) {
  ImageU8 photo(20, 10, 3, 50);
  photo(5, 2, 0) = 200;
  const auto crop = CropInstance(photo, Labels(), 4, 0.5);
  ASSERT_TRUE(crop.has_value());
  // Twice as wide as the longer side, 6; centred on (8, 4).
  EXPECT_EQ(crop->in_place.width(), 12);
  EXPECT_EQ(crop->in_place.height(), 12);
  EXPECT_EQ(crop->in_place(3, 4, 0), 200);
  EXPECT_EQ(crop->alone(3, 4, 0), 200);
  EXPECT_EQ(crop->in_place(2, 4, 0), 50);  // Beside it.
  EXPECT_EQ(crop->alone(2, 4, 0), 123);
  EXPECT_EQ(crop->in_place(3, 0, 1), 117);  // Above the photograph.
}

TEST(InstanceCropsTest, NothingOfALabelThatIsNotThere) {
  EXPECT_FALSE(CropInstance(ImageU8(20, 10, 3), Labels(), 7, 0.1).has_value());
}

TEST(InstanceCropsTest, TinyInstancesKeepASideThatCanBeSeen) {
  Image<int32_t> labels(20, 10, 1, -1);
  labels(19, 9) = 2;
  const auto crop = CropInstance(ImageU8(20, 10, 3, 9), labels, 2, 0.0);
  ASSERT_TRUE(crop.has_value());
  EXPECT_EQ(crop->in_place.width(), 8);
}

TEST(InstanceCropsTest, CountsPixelsAndWhatTheBorderCuts) {
  const std::vector<LabelSight> sights = SightsOf(3, Labels(), 5);
  ASSERT_EQ(sights.size(), 5u);
  EXPECT_EQ(sights[4].view, 3u);
  EXPECT_EQ(sights[4].pixels, 24);
  EXPECT_FALSE(sights[4].cut);
  EXPECT_GT(sights[0].pixels, 0);
  EXPECT_TRUE(sights[0].cut);
  EXPECT_EQ(sights[1].pixels, 0);
}

TEST(InstanceCropsTest, BestSightsShowMuchAndAreNotCut) {
  const std::vector<LabelSight> best = BestSights(
      {{0, 10, false}, {1, 30, true}, {2, 16, false}, {3, 15, false}}, 3);
  ASSERT_EQ(best.size(), 3u);
  EXPECT_EQ(best[0].view, 2u);
  EXPECT_EQ(best[1].view, 1u);  // Half of 30: a tie, and the earlier view.
  EXPECT_EQ(best[2].view, 3u);
}

}  // namespace
}  // namespace freegs::semantics
