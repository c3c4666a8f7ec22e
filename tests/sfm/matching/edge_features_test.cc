// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/matching/edge_features.h"

#include <gtest/gtest.h>

namespace freegs::sfm {
namespace {

TEST(EdgeFeaturesTest, TheLastRowDependsOnTheOctave) {
  // Features of COLMAP 3.8 in pictures of 240 rows whose descriptors differed
  // from run to run.
  EXPECT_TRUE(IsInLastRow(239.8, 1.25, 240));
  EXPECT_TRUE(IsInLastRow(239.0, 3.18, 240));
  EXPECT_TRUE(IsInLastRow(237.7, 7.03, 240));
  // A fine feature there has whole rows below it.
  EXPECT_FALSE(IsInLastRow(237.7, 1.25, 240));
  EXPECT_FALSE(IsInLastRow(230, 7.03, 240));
  EXPECT_FALSE(IsInLastRow(1, 7.03, 240));
  EXPECT_FALSE(IsInLastRow(239.8, 0, 240));
}

TEST(EdgeFeaturesTest, UnsetDescriptorsBecomeZero) {
  SiftDescriptors descriptors;
  descriptors.values.assign(3 * kSiftDimensions, 7);
  // In a photo of twice the size of the image.
  const std::vector<FeaturePlace> features = {
      {100, 400, 14}, {100, 475.4f, 14.06f}, {100, 20, 14}};
  ClearUnsetDescriptors(features, 640, 480, 320, &descriptors);
  EXPECT_EQ(descriptors.values[kSiftDimensions - 1], 7);
  EXPECT_EQ(descriptors.values[kSiftDimensions], 0);
  EXPECT_EQ(descriptors.values[2 * kSiftDimensions - 1], 0);
  EXPECT_EQ(descriptors.values[2 * kSiftDimensions], 7);
  EXPECT_TRUE(
      MatchDescriptors({{descriptors.values.begin() + kSiftDimensions,
                         descriptors.values.begin() + 2 * kSiftDimensions}},
                       descriptors)
          .empty());
}

TEST(EdgeFeaturesTest, WithoutPlacesNothingIsCleared) {
  SiftDescriptors descriptors;
  descriptors.values.assign(kSiftDimensions, 7);
  ClearUnsetDescriptors({}, 640, 480, 320, &descriptors);
  ClearUnsetDescriptors({{1, 479, 3}}, 0, 0, 320, &descriptors);
  EXPECT_EQ(descriptors.values[0], 7);
}

}  // namespace
}  // namespace freegs::sfm
