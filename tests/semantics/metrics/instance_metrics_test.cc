// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/metrics/instance_metrics.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::semantics {
namespace {

// Object 1 is columns 0..3, object 2 columns 4..5, column 6..7 background.
ImageU16 Truth() {
  ImageU16 truth(8, 4, 1);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 6; ++x) truth(x, y) = x < 4 ? 1 : 2;
  }
  return truth;
}

// Instance 5 is columns 0..2, instance 9 columns 3..6, the rest nobody's.
Image<int32_t> Instances() {
  Image<int32_t> instances(8, 4, 1, -1);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 7; ++x) instances(x, y) = x < 3 ? 5 : 9;
  }
  return instances;
}

TEST(CountOverlap, CountsByHand) {
  const InstanceOverlap overlap = *CountOverlap(Truth(), Instances());
  EXPECT_EQ(overlap.truth_pixels.at(1), 16);
  EXPECT_EQ(overlap.truth_pixels.at(2), 8);
  EXPECT_EQ(overlap.truth_pixels.size(), 2u);
  EXPECT_EQ(overlap.instance_pixels.at(5), 12);
  EXPECT_EQ(overlap.instance_pixels.at(9), 16);
  EXPECT_DOUBLE_EQ(overlap.Iou(1, 5), 12.0 / 16);
  EXPECT_DOUBLE_EQ(overlap.Iou(1, 9), 4.0 / 28);
  EXPECT_DOUBLE_EQ(overlap.Iou(2, 9), 8.0 / 16);
  EXPECT_DOUBLE_EQ(overlap.Iou(2, 5), 0);
  EXPECT_DOUBLE_EQ(overlap.Iou(3, 77), 0);
}

TEST(CountOverlap, SumsOverViews) {
  InstanceOverlap sum = *CountOverlap(Truth(), Instances());
  Image<int32_t> nothing(8, 4, 1, -1);
  sum.Add(*CountOverlap(Truth(), nothing));
  EXPECT_DOUBLE_EQ(sum.Iou(1, 5), 12.0 / 32);
}

TEST(CountOverlap, RefusesOtherSizes) {
  EXPECT_FALSE(CountOverlap(ImageU16(3, 4, 1), Image<int32_t>(4, 3, 1)).ok());
}

TEST(BestMatch, TakesTheHighestIou) {
  const InstanceOverlap overlap = *CountOverlap(Truth(), Instances());
  EXPECT_EQ(BestMatch(overlap, 1)->instance, 5);
  EXPECT_DOUBLE_EQ(BestMatch(overlap, 1)->iou, 0.75);
  EXPECT_EQ(BestMatch(overlap, 2)->instance, 9);
  EXPECT_FALSE(BestMatch(overlap, 3).has_value());
}

TEST(BestMatch, TiesGoToTheSmallerInstance) {
  ImageU16 truth(2, 1, 1, 1);
  Image<int32_t> instances(2, 1, 1);
  instances(0, 0) = 8;
  instances(1, 0) = 3;
  EXPECT_EQ(BestMatch(*CountOverlap(truth, instances), 1)->instance, 3);
}

TEST(ClickPoint, IsTheMiddleOfASquare) {
  ImageU16 truth(20, 20, 1);
  for (int y = 5; y < 12; ++y) {
    for (int x = 3; x < 10; ++x) truth(x, y) = 4;
  }
  EXPECT_EQ(*ClickPoint(truth, 4), Eigen::Vector2i(6, 8));
  EXPECT_FALSE(ClickPoint(truth, 5).has_value());
}

TEST(ClickPoint, TheImageBorderIsAnEdge) {
  // A mask that fills the image: the middle, not a corner.
  EXPECT_EQ(*ClickPoint(ImageU16(9, 5, 1, 1), 1), Eigen::Vector2i(2, 2));
  EXPECT_EQ(*ClickPoint(ImageU16(1, 1, 1, 1), 1), Eigen::Vector2i(0, 0));
}

TEST(ClickPoint, MatchesBruteForce) {
  for (uint64_t seed = 0; seed < 5; ++seed) {
    ImageU16 truth(24, 18, 1);
    for (size_t i = 0; i < truth.size(); ++i) {
      truth.data()[i] = RandomUniform(seed, 0, i) < 0.93 ? 2 : 7;
    }
    double deepest = 0;
    const auto depth = [&truth](int x, int y) {
      double best = 1e9;
      for (int v = -1; v <= truth.height(); ++v) {
        for (int u = -1; u <= truth.width(); ++u) {
          const bool outside =
              u < 0 || v < 0 || u >= truth.width() || v >= truth.height();
          if (!outside && truth(u, v) == 2) continue;
          best = std::min<double>(best, (u - x) * (u - x) + (v - y) * (v - y));
        }
      }
      return best;
    };
    for (int y = 0; y < truth.height(); ++y) {
      for (int x = 0; x < truth.width(); ++x) {
        if (truth(x, y) == 2) deepest = std::max(deepest, depth(x, y));
      }
    }
    const Eigen::Vector2i click = *ClickPoint(truth, 2);
    EXPECT_EQ(truth(click.x(), click.y()), 2);
    EXPECT_NEAR(depth(click.x(), click.y()), deepest, 1e-3);
  }
}

TEST(MaskIou, KnownMasks) {
  ImageU8 a(4, 1, 1);
  ImageU8 b(4, 1, 1);
  EXPECT_EQ(*MaskIou(a, b), 0);
  a(0, 0) = 255;
  a(1, 0) = 1;
  b(1, 0) = 255;
  b(2, 0) = 255;
  EXPECT_DOUBLE_EQ(*MaskIou(a, b), 1.0 / 3);
  EXPECT_DOUBLE_EQ(*MaskIou(a, a), 1);
  EXPECT_FALSE(MaskIou(a, ImageU8(1, 4, 1)).ok());
}

}  // namespace
}  // namespace freegs::semantics
