// SPDX-License-Identifier: BSD-3-Clause

#include "splat/density/camera_clearance.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::splat {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// Looks along +z from `centre`, 90 degrees wide.
View ViewFrom(const Eigen::Vector3d& centre) {
  View view;
  view.camera = {100, 100, 50, 50, 50, 50};
  view.cam_from_world.translation = -centre;
  return view;
}

GaussianModel ModelAt(const std::vector<Eigen::Vector3f>& means) {
  GaussianModel model;
  model.Resize(means.size());
  for (size_t i = 0; i < means.size(); ++i) {
    Eigen::Vector3f::Map(&model.means[3 * i]) = means[i];
  }
  return model;
}

TEST(ClearBalls, AQuarterOfTheNearPointsDistance) {
  ThreadPool pool(2);
  // One in fifty points is wrong, next to the camera; one is behind it.
  std::vector<Eigen::Vector3f> points(98, {0, 0, 8});
  points.push_back({0, 0, 0.01f});
  points.push_back({0, 0, -1});
  points.push_back({30, 0, 3});  // Beside the picture.
  const std::vector<View> views = {ViewFrom({0, 0, 0}), ViewFrom({1, 0, 4})};
  const auto balls = ClearBalls({}, views, ModelAt(points), pool);
  ASSERT_THAT(balls, SizeIs(2));
  EXPECT_FLOAT_EQ(balls[0].radius, 2);
  EXPECT_EQ(balls[1].centre, Eigen::Vector3f(1, 0, 4));
  EXPECT_NEAR(balls[1].radius, 0.25 * std::sqrt(17.0), 1e-6);
}

TEST(ClearBalls, NoneWithoutPointsOrFactor) {
  ThreadPool pool(1);
  const std::vector<View> views = {ViewFrom({0, 0, 0})};
  EXPECT_THAT(ClearBalls({}, views, {}, pool), IsEmpty());
  EXPECT_THAT(ClearBalls({}, views, ModelAt({{0, 0, -3}}), pool), IsEmpty());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(ClearBalls({}, views, ModelAt({{nan, 0, 3}}), pool), IsEmpty());
  EXPECT_THAT(ClearBalls({.factor = 0}, views, ModelAt({{0, 0, 3}}), pool),
              IsEmpty());
}

TEST(ClearBalls, OptionsAreChecked) {
  EXPECT_TRUE(CameraClearanceOptions().Check().ok());
  EXPECT_FALSE(CameraClearanceOptions{.factor = 1}.Check().ok());
  EXPECT_FALSE(CameraClearanceOptions{.near_quantile = -0.1}.Check().ok());
}

TEST(OutsideBalls, ByTheDistanceOfTheMean) {
  ThreadPool pool(2);
  const std::vector<ClearBall> balls = {{{0, 0, 0}, 1}, {{5, 0, 0}, 2}};
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const GaussianModel model = ModelAt(
      {{0.9f, 0, 0}, {1.1f, 0, 0}, {4, 1, 1}, {nan, 0, 0}, {5, 0, 2.5f}});
  // What is not finite is noticed elsewhere.
  EXPECT_THAT(OutsideBalls(balls, model, pool), ElementsAre(1, 3, 4));
  EXPECT_THAT(OutsideBalls({}, model, pool), SizeIs(5));
}

}  // namespace
}  // namespace freegs::splat
