// SPDX-License-Identifier: BSD-3-Clause

#include "splat/scene/initialization.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::splat {
namespace {

using Colors = std::vector<std::array<uint8_t, 3>>;

std::vector<Eigen::Vector3d> RandomPoints(size_t count, uint64_t seed) {
  RandomStream random(seed, 0);
  std::vector<Eigen::Vector3d> points(count);
  for (Eigen::Vector3d& point : points) {
    for (int k = 0; k < 3; ++k) point[k] = random.Uniform();
  }
  return points;
}

double ScaleOf(const GaussianModel& model, size_t i) {
  return std::exp(static_cast<double>(model.log_scales[3 * i]));
}

View ViewAt(const Eigen::Vector3d& centre) {
  View view;
  view.cam_from_world.rotation =
      Eigen::Quaterniond(0.8, 0.1, 0.5, -0.3).normalized();
  view.cam_from_world.translation = view.cam_from_world.rotation * -centre;
  return view;
}

TEST(InitializationTest, ScaleIsTheDistanceToTheNeighbours) {
  // Far from the origin, where floats are coarse.
  std::vector<Eigen::Vector3d> points = RandomPoints(500, 1);
  for (Eigen::Vector3d& point : points) {
    point += Eigen::Vector3d(4e5, -3e5, 100);
  }
  const StatusOr<GaussianModel> model =
      InitializeFromPoints(points, Colors(500), 1.0);
  ASSERT_TRUE(model.ok());
  ASSERT_EQ(model->size(), 500u);
  for (size_t i = 0; i < points.size(); ++i) {
    std::vector<double> squares;
    for (size_t j = 0; j < points.size(); ++j) {
      if (j != i) squares.push_back((points[i] - points[j]).squaredNorm());
    }
    std::partial_sort(squares.begin(), squares.begin() + 3, squares.end());
    const double expected =
        std::sqrt((squares[0] + squares[1] + squares[2]) / 3);
    ASSERT_NEAR(ScaleOf(*model, i) / expected, 1.0, 1e-4) << i;
  }
  EXPECT_EQ(model->log_scales[0], model->log_scales[1]);
  EXPECT_EQ(model->log_scales[0], model->log_scales[2]);
}

// The sums of all points would lie far from the others.
TEST(InitializationTest, OnePointFarAwayChangesNoOther) {
  std::vector<Eigen::Vector3d> points = RandomPoints(500, 6);
  const StatusOr<GaussianModel> without =
      InitializeFromPoints(points, Colors(500), 1.0);
  points.emplace_back(1e11, 0, -1e11);
  const StatusOr<GaussianModel> with =
      InitializeFromPoints(points, Colors(501), 1.0);
  ASSERT_TRUE(without.ok());
  ASSERT_TRUE(with.ok());
  ASSERT_EQ(with->size(), 501u);
  for (size_t k = 0; k < without->log_scales.size(); ++k) {
    ASSERT_NEAR(with->log_scales[k], without->log_scales[k], 1e-5) << k;
  }
}

TEST(InitializationTest, OtherParameters) {
  const std::vector<Eigen::Vector3d> points = RandomPoints(5, 2);
  const Colors colors(5, {255, 0, 51});
  const StatusOr<GaussianModel> model = InitializeFromPoints(
      points, colors, 1.0, {.opacity = 0.25, .sh_degree = 2});
  ASSERT_TRUE(model.ok());
  EXPECT_EQ(model->sh_degree, 2);
  EXPECT_EQ(model->sh_rest, std::vector<float>(5 * 24, 0.0f));
  EXPECT_FLOAT_EQ(model->opacity_logits[3], std::log(0.25f / 0.75f));
  EXPECT_EQ(model->rotations[4 * 4], 1.0f);
  EXPECT_EQ(model->rotations[4 * 4 + 2], 0.0f);
  EXPECT_FLOAT_EQ(kShC0 * model->sh_dc[3] + 0.5f, 1.0f);
  // Not quite black, so that it has a gradient.
  EXPECT_NEAR(kShC0 * model->sh_dc[4] + 0.5f, 1 / 255.0f, 1e-6f);
  EXPECT_FLOAT_EQ(kShC0 * model->sh_dc[5] + 0.5f, 0.2f);
  EXPECT_FLOAT_EQ(model->means[5], static_cast<float>(points[1].z()));
}

TEST(InitializationTest, FewPoints) {
  const std::vector<Eigen::Vector3d> points = {{0, 0, 0}, {3, 0, 0}, {0, 4, 0}};
  const auto scale = [&](size_t count) {
    const StatusOr<GaussianModel> model = InitializeFromPoints(
        std::span(points).first(count), Colors(count), 10.0);
    return model.ok() ? ScaleOf(*model, 0) : -1.0;
  };
  EXPECT_NEAR(scale(1), 0.1, 1e-6);
  EXPECT_NEAR(scale(2), 3.0, 1e-6);
  EXPECT_NEAR(scale(3), std::sqrt((9.0 + 16.0) / 2), 1e-5);
  EXPECT_EQ(scale(0), -1.0);
}

TEST(InitializationTest, CoincidentPointsTakeOtherPositions) {
  std::vector<Eigen::Vector3d> points(100, Eigen::Vector3d(1, 1, 1));
  points.emplace_back(1, 1, 3);
  const StatusOr<GaussianModel> model =
      InitializeFromPoints(points, Colors(101), 10.0);
  ASSERT_TRUE(model.ok());
  EXPECT_NEAR(ScaleOf(*model, 0), 2.0, 1e-5);
  EXPECT_NEAR(ScaleOf(*model, 100), 2.0, 1e-5);

  points.pop_back();
  const StatusOr<GaussianModel> same =
      InitializeFromPoints(points, Colors(100), 10.0);
  ASSERT_TRUE(same.ok());
  EXPECT_EQ(same->size(), 100u);
  EXPECT_NEAR(ScaleOf(*same, 7), 0.1, 1e-6);
}

TEST(InitializationTest, ScalesAreBounded) {
  const std::vector<Eigen::Vector3d> points = {
      {0, 0, 0}, {1e-9, 0, 0}, {2e-9, 0, 0}, {3e-9, 0, 0}, {1e6, 0, 0}};
  const StatusOr<GaussianModel> model =
      InitializeFromPoints(points, Colors(5), 2.0);
  ASSERT_TRUE(model.ok());
  EXPECT_TRUE(model->AllFinite());
  for (size_t i = 0; i < 5; ++i) {
    EXPECT_GE(ScaleOf(*model, i), 1.999e-5);
    EXPECT_LE(ScaleOf(*model, i), 2.001);
  }
}

TEST(InitializationTest, LeavesOutPointsThatAreNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Eigen::Vector3d> points = {
      {nan, 0, 0}, {1, 2, 3}, {0, 1e300, 0}, {2, 2, 3}};
  const Colors colors = {{1, 1, 1}, {255, 255, 255}, {1, 1, 1}, {0, 0, 0}};
  const StatusOr<GaussianModel> model =
      InitializeFromPoints(points, colors, 1.0);
  ASSERT_TRUE(model.ok());
  ASSERT_EQ(model->size(), 2u);
  EXPECT_EQ(model->means[3], 2.0f);
  EXPECT_GT(model->sh_dc[0], 0.0f);
  EXPECT_LT(model->sh_dc[3], 0.0f);
}

TEST(InitializationTest, StoredColoursAreKeptExactly) {
  const std::vector<Eigen::Vector3d> points = RandomPoints(3, 2);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<std::array<float, 3>> colors = {
      {0.1f, -1.7f, 1e-9f}, {0, nan, 0}, {1.0f / 3, 5, 6}};
  const StatusOr<GaussianModel> model = InitializeFromShDc(points, colors, 1.0);
  ASSERT_TRUE(model.ok());
  EXPECT_EQ(model->sh_dc,
            (std::vector<float>{0.1f, -1.7f, 1e-9f, 1.0f / 3, 5, 6}));
  EXPECT_EQ(model->means[3], static_cast<float>(points[2].x()));
}

// Below 0 they would have no gradient. One that is not finite is still left
// out.
TEST(InitializationTest, StoredColoursAreNotQuiteBlack) {
  const std::vector<Eigen::Vector3d> points = RandomPoints(2, 2);
  const float infinity = std::numeric_limits<float>::infinity();
  const std::vector<std::array<float, 3>> colors = {{-7.3f, -0.5f / kShC0, 0},
                                                    {0, -infinity, 0}};
  const StatusOr<GaussianModel> model = InitializeFromShDc(points, colors, 1.0);
  ASSERT_TRUE(model.ok());
  ASSERT_EQ(model->size(), 1u);
  EXPECT_NEAR(kShC0 * model->sh_dc[0] + 0.5f, 1 / 255.0f, 1e-6f);
  EXPECT_EQ(model->sh_dc[1], model->sh_dc[0]);
  EXPECT_EQ(model->sh_dc[2], 0.0f);
}

TEST(InitializationTest, WrongUseIsRefused) {
  const std::vector<Eigen::Vector3d> points = RandomPoints(4, 2);
  EXPECT_FALSE(InitializeFromPoints(points, Colors(3), 1.0).ok());
  EXPECT_FALSE(InitializeFromPoints(points, Colors(4), 0.0).ok());
  EXPECT_FALSE(
      InitializeFromPoints(points, Colors(4), 1.0, {.opacity = 1}).ok());
  EXPECT_FALSE(
      InitializeFromPoints(points, Colors(4), 1.0, {.sh_degree = 4}).ok());
}

TEST(SceneExtentTest, LargestDistanceFromTheMeanCamera) {
  const std::vector<View> views = {
      ViewAt({1, 0, 0}), ViewAt({-1, 0, 0}), ViewAt({0, 6, 0})};
  EXPECT_NEAR(SceneExtent(views, {}), 1.1 * 4.0, 1e-9);
}

TEST(SceneExtentTest, CoincidentCamerasFallBackToThePoints) {
  const std::vector<View> views(5, ViewAt({1, 1, 1}));
  const std::vector<Eigen::Vector3d> points = {
      {1, 1, 2},
      {1, 1, 4},
      {1, 1, 100},
      {0, 0, std::numeric_limits<double>::infinity()}};
  EXPECT_NEAR(SceneExtent(views, points), 3.0, 1e-9);
  EXPECT_EQ(SceneExtent(views, {}), 1.0);
  EXPECT_EQ(SceneExtent({}, {}), 1.0);
}

}  // namespace
}  // namespace freegs::splat
