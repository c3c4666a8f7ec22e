// SPDX-License-Identifier: BSD-3-Clause

#include "splat/density/camera_clearance.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"

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

// Nearer points at every second place of the list count until the list has
// twice as many points as are looked at.
TEST(ClearBalls, OfVeryManyPointsAFewStandForAll) {
  ThreadPool pool(2);
  const std::vector<View> views = {ViewFrom({0, 0, 0})};
  const auto radius = [&](size_t count) {
    std::vector<Eigen::Vector3f> points(count, {0, 0, 8});
    for (size_t i = 1; i < count; i += 2) points[i].z() = 4;
    const auto balls = ClearBalls({}, views, ModelAt(points), pool);
    return balls.size() == 1 ? balls[0].radius : -1;
  };
  EXPECT_FLOAT_EQ(radius(kMaxClearancePoints), 1);
  EXPECT_FLOAT_EQ(radius(kMaxClearancePoints * 3 / 2), 1);
  EXPECT_FLOAT_EQ(radius(2 * kMaxClearancePoints), 2);
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

// Compares every Gaussian with every ball.
std::vector<uint32_t> OutsideEach(const std::vector<ClearBall>& balls,
                                  const GaussianModel& model) {
  std::vector<uint32_t> outside;
  for (size_t i = 0; i < model.size(); ++i) {
    const Eigen::Vector3f mean = Eigen::Vector3f::Map(&model.means[3 * i]);
    bool inside = false;
    for (const ClearBall& ball : balls) {
      inside |= (mean - ball.centre).squaredNorm() < ball.radius * ball.radius;
    }
    if (!inside) outside.push_back(static_cast<uint32_t>(i));
  }
  return outside;
}

TEST(OutsideBalls, AsIfEachWereComparedWithEach) {
  ThreadPool pool(2);
  const auto normal = [](int stream, size_t i) {
    return Eigen::Vector3f(
        static_cast<float>(RandomNormal(7, stream, 3 * i)),
        static_cast<float>(RandomNormal(7, stream, 3 * i + 1)),
        static_cast<float>(RandomNormal(7, stream, 3 * i + 2)));
  };
  // The scene in units of 1, or of less and more; at the origin and far from
  // it, where floats are coarse.
  for (const float unit : {1e-12f, 1.0f, 1e12f}) {
    for (const float offset : {0.0f, 1e5f, 1e9f}) {
      std::vector<ClearBall> balls;
      for (size_t i = 0; i < 150; ++i) {
        const double size = std::exp2(2 * RandomNormal(7, 1, i) - 3);
        balls.push_back(
            {unit * (normal(2, i) + Eigen::Vector3f::Constant(offset)),
             unit * static_cast<float>(size)});
      }
      // A camera that was placed wrong and one that looks at the horizon.
      balls.push_back({unit * Eigen::Vector3f(1e6f, -1e6f, 1e6f), unit});
      balls.push_back({unit * Eigen::Vector3f(0, 0, 1e4f), 9.9e3f * unit});
      std::vector<Eigen::Vector3f> means;
      for (size_t i = 0; i < 1000; ++i) {
        means.push_back(unit *
                        (2 * normal(3, i) + Eigen::Vector3f::Constant(offset)));
        // At the rim of a ball, where rounding decides.
        const ClearBall& ball = balls[i % balls.size()];
        means.push_back(ball.centre + ball.radius * normal(4, i).normalized());
        means.push_back(ball.centre +
                        ball.radius *
                            Eigen::Vector3f::Unit(static_cast<int>(i % 3)));
      }
      const float infinity = std::numeric_limits<float>::infinity();
      means.push_back({infinity, 0, 0});
      means.push_back({0, -std::numeric_limits<float>::max(), 0});
      const GaussianModel model = ModelAt(means);
      const std::vector<uint32_t> expected = OutsideEach(balls, model);
      EXPECT_THAT(expected, testing::Not(IsEmpty()));
      EXPECT_LT(expected.size(), means.size() - 2);
      EXPECT_EQ(OutsideBalls(balls, model, pool), expected)
          << unit << " " << offset;
    }
  }
}

}  // namespace
}  // namespace freegs::splat
