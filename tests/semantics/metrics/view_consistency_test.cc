// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/metrics/view_consistency.h"

#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

constexpr int kWidth = 40;
constexpr int kHeight = 10;

// A wall 2 units away, seen by a camera `shift` units to the right that looks
// straight at it: 0.02 units per pixel. Instance 0 is left of pixel column
// `border`, instance 1 right of it.
LabelledView Wall(double shift, int border) {
  LabelledView view;
  view.view.camera = {kWidth, kHeight, 100, 100, 20, 5};
  view.view.cam_from_world.translation = {-shift, 0, 0};
  view.labels = Image<int32_t>(kWidth, kHeight, 1, 1);
  view.depth = ImageF(kWidth, kHeight, 1, 2.0f);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < border; ++x) view.labels(x, y) = 0;
  }
  return view;
}

TEST(CompareViews, AgreesWhereLabelsLieOnTheSurface) {
  const auto ious = CompareViews(Wall(0, 20), Wall(0.1, 15), {});
  ASSERT_TRUE(ious.ok());
  EXPECT_EQ(*ious, (std::map<int, double>{{0, 1.0}, {1, 1.0}}));
}

TEST(CompareViews, CountsDisagreementByHand) {
  // 35 columns are seen by both. Where one view ends instance 0, the other goes
  // on for two columns more.
  const auto ious = CompareViews(Wall(0, 20), Wall(0.1, 17), {});
  ASSERT_TRUE(ious.ok());
  EXPECT_DOUBLE_EQ(ious->at(0), 15.0 / 17);
  EXPECT_DOUBLE_EQ(ious->at(1), 18.0 / 20);
}

TEST(CompareViews, LeavesOutWhatIsHidden) {
  LabelledView to = Wall(0.1, 3);  // Labels that would disagree ...
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < 20; ++x) to.depth(x, y) = 1;  // ... on something else.
  }
  const auto ious = CompareViews(Wall(0, 20), to, {});
  ASSERT_TRUE(ious.ok());
  EXPECT_EQ(*ious, (std::map<int, double>{{1, 1.0}}));
}

TEST(CompareViews, LeavesOutWhatIsSmallOrNothing) {
  LabelledView from = Wall(0, 20);
  LabelledView to = Wall(0, 1);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) from.labels(x, y) = -1;
  }
  const auto ious = CompareViews(from, to, {});
  ASSERT_TRUE(ious.ok());
  EXPECT_EQ(*ious, (std::map<int, double>{{1, 0.0}}));  // 0 has 10 pixels.
  from.depth = ImageF(kWidth, kHeight, 1, 0.0f);
  EXPECT_TRUE(CompareViews(from, to, {})->empty());
}

TEST(CompareViews, SeesNothingBehindTheCamera) {
  LabelledView to = Wall(0, 20);
  to.view.cam_from_world.translation = {0, 0, -5};
  EXPECT_TRUE(CompareViews(Wall(0, 20), to, {})->empty());
}

TEST(CompareViews, RefusesWrongSizesAndOptions) {
  LabelledView to = Wall(0, 20);
  EXPECT_FALSE(CompareViews(Wall(0, 20), to, {.depth_tolerance = 0}).ok());
  EXPECT_FALSE(CompareViews(Wall(0, 20), to, {.min_pixels = 0}).ok());
  to.depth = ImageF(3, 3, 1);
  EXPECT_FALSE(CompareViews(Wall(0, 20), to, {}).ok());
  EXPECT_FALSE(CompareViews(to, Wall(0, 20), {}).ok());
}

TEST(NeighbouringViews, AreTheNearestThatLookTheSameWay) {
  const auto view = [](double x, double angle) {
    View view;
    view.cam_from_world.rotation =
        Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY());
    view.cam_from_world.translation =
        view.cam_from_world.rotation * Eigen::Vector3d(-x, 0, 0);
    return view;
  };
  using Pairs = std::vector<std::pair<size_t, size_t>>;
  EXPECT_EQ(NeighbouringViews({view(0, 0), view(1, 0), view(5, 0)}),
            (Pairs{{0, 1}, {1, 2}}));
  EXPECT_EQ(
      NeighbouringViews({view(0, 0), view(1, std::numbers::pi), view(5, 0.5)}),
      (Pairs{{0, 2}}));
  EXPECT_TRUE(NeighbouringViews({view(0, 0)}).empty());
  EXPECT_TRUE(NeighbouringViews({}).empty());
}

}  // namespace
}  // namespace freegs::semantics
