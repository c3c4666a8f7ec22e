// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/metrics/panoptic_quality.h"

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

InstanceOverlap Overlap() {
  InstanceOverlap overlap;
  // Object 1 and instance 5 agree well, object 2 and instance 9 just not well
  // enough, object 3 is not found, instance 7 lies where nothing is known.
  overlap.truth_pixels = {{1, 160}, {2, 80}, {3, 50}};
  overlap.instance_pixels = {{5, 120}, {7, 200}, {9, 160}};
  overlap.shared_pixels = {
      {{1, 5}, 120}, {{1, 9}, 40}, {{2, 9}, 80}, {{3, 7}, 50}};
  return overlap;
}

TEST(MatchSegments, CountsByHand) {
  const PanopticQuality quality = MatchSegments(Overlap(), 1);
  EXPECT_EQ(quality.true_positives, 1);
  EXPECT_EQ(quality.false_negatives, 2);
  EXPECT_EQ(quality.false_positives, 1);  // Instance 9; 7 is mostly elsewhere.
  EXPECT_DOUBLE_EQ(*quality.Segmentation(), 0.75);
  EXPECT_DOUBLE_EQ(*quality.Recognition(), 1.0 / 2.5);
  EXPECT_DOUBLE_EQ(*quality.Quality(), 0.3);
}

TEST(MatchSegments, LeavesOutWhatIsSmall) {
  const PanopticQuality quality = MatchSegments(Overlap(), 100);
  EXPECT_EQ(quality.true_positives, 1);
  EXPECT_EQ(quality.false_negatives, 0);
  // Only the 40 pixels of instance 9 on object 1 are on anything judged.
  EXPECT_EQ(quality.false_positives, 0);
  EXPECT_DOUBLE_EQ(*quality.Quality(), 0.75);
}

TEST(MatchSegments, SumsOverViews) {
  PanopticQuality sum = MatchSegments(Overlap(), 1);
  InstanceOverlap perfect;
  perfect.truth_pixels = {{1, 100}};
  perfect.instance_pixels = {{5, 100}};
  perfect.shared_pixels = {{{1, 5}, 100}};
  EXPECT_DOUBLE_EQ(*MatchSegments(perfect, 1).Quality(), 1);
  sum.Add(MatchSegments(perfect, 1));
  EXPECT_DOUBLE_EQ(*sum.Segmentation(), 1.75 / 2);
  EXPECT_DOUBLE_EQ(*sum.Recognition(), 2 / 3.5);
  EXPECT_DOUBLE_EQ(*sum.Quality(), 0.5);
}

TEST(MatchSegments, OfEmptyMasks) {
  EXPECT_FALSE(MatchSegments(InstanceOverlap(), 1).Quality().has_value());
  InstanceOverlap missed;
  missed.truth_pixels = {{1, 100}};
  EXPECT_EQ(*MatchSegments(missed, 1).Quality(), 0);
  EXPECT_EQ(*MatchSegments(missed, 1).Segmentation(), 0);
  // An instance where there is no truth at all says nothing.
  InstanceOverlap unknown;
  unknown.instance_pixels = {{1, 100}};
  EXPECT_FALSE(MatchSegments(unknown, 1).Quality().has_value());
}

}  // namespace
}  // namespace freegs::semantics
