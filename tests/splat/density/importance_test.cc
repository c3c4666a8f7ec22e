// SPDX-License-Identifier: BSD-3-Clause
// What views add up to, and which metric which scene gets.

#include "splat/density/importance.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::splat {
namespace {

using Points = std::vector<Eigen::Vector3d>;

ViewContributions Contributions(std::vector<uint32_t> model_index,
                                std::vector<float> weight_sum,
                                std::vector<uint32_t> num_pixels,
                                std::vector<uint32_t> num_dominant) {
  ViewContributions contributions;
  contributions.model_index = std::move(model_index);
  contributions.weight_sum = std::move(weight_sum);
  contributions.num_pixels = std::move(num_pixels);
  contributions.num_dominant = std::move(num_dominant);
  return contributions;
}

TEST(ImportanceAccumulatorTest, SumsOverViews) {
  ImportanceAccumulator accumulator(4);
  EXPECT_EQ(accumulator.size(), 4u);
  accumulator.AddView(
      Contributions({2, 0, 1}, {6.0f, 2.0f, 9.0f}, {12, 8, 10}, {3, 0, 0}));
  accumulator.AddView(
      Contributions({0, 2, 1}, {3.0f, 1.0f, 9.0f}, {4, 10, 10}, {1, 0, 0}));
  // 0 and 2 are the largest in one view each, 1 is never, 3 never seen.
  EXPECT_EQ(accumulator.Importance(ImportanceMetric::kIndoor),
            (std::vector<float>{5.0f, 0.0f, 7.0f, 0.0f}));
  EXPECT_EQ(accumulator.Importance(ImportanceMetric::kOutdoor),
            (std::vector<float>{0.75f, 0.0f, 0.5f, 0.0f}));
}

TEST(ImportanceAccumulatorTest, BadWeightsAndEmptyViewsAddNothing) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  ImportanceAccumulator accumulator(4);
  accumulator.AddView({});
  accumulator.AddView(Contributions(
      {0, 1, 2, 3}, {nan, -1.0f, infinity, 1.0f}, {1, 1, 1, 0}, {1, 1, 1, 1}));
  for (const ImportanceMetric metric :
       {ImportanceMetric::kIndoor, ImportanceMetric::kOutdoor}) {
    EXPECT_EQ(accumulator.Importance(metric), (std::vector<float>{0, 0, 0, 1}));
  }
  EXPECT_TRUE(
      ImportanceAccumulator(0).Importance(ImportanceMetric::kIndoor).empty());
}

// Uniform in a box.
Points InBox(size_t count,
             const Eigen::Vector3d& low,
             const Eigen::Vector3d& high,
             uint64_t stream) {
  RandomStream random(5, stream);
  Points points(count);
  for (Eigen::Vector3d& point : points) {
    for (int axis = 0; axis < 3; ++axis) {
      point[axis] = low[axis] + (high[axis] - low[axis]) * random.Uniform();
    }
  }
  return points;
}

// On the six faces of a box.
Points OnWalls(size_t count,
               const Eigen::Vector3d& low,
               const Eigen::Vector3d& high,
               uint64_t stream) {
  Points points = InBox(count, low, high, stream);
  for (size_t i = 0; i < count; ++i) {
    const auto axis = static_cast<Eigen::Index>(i % 3);
    points[i][axis] = i % 2 == 0 ? low[axis] : high[axis];
  }
  return points;
}

// Around the middle, distances log-uniform.
Points Background(size_t count, double nearest, double farthest) {
  RandomStream random(6, 0);
  Points points(count);
  for (Eigen::Vector3d& point : points) {
    const double angle = 2 * std::numbers::pi * random.Uniform();
    const double distance =
        nearest * std::pow(farthest / nearest, random.Uniform());
    point = distance * Eigen::Vector3d(std::cos(angle),
                                       -0.3 * random.Uniform(),
                                       std::sin(angle));
  }
  return points;
}

Points Ring(size_t count, double radius) {
  Points points(count);
  for (size_t i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) /
                         static_cast<double>(count);
    points[i] = {radius * std::cos(angle), -0.5, radius * std::sin(angle)};
  }
  return points;
}

// The choice for cameras at `centres` and Gaussians at the points of all parts.
ImportanceMetric Choice(const Points& centres,
                        const std::vector<Points>& parts) {
  std::vector<View> views;
  for (const Eigen::Vector3d& centre : centres) {
    View view;
    view.cam_from_world.rotation =
        Eigen::Quaterniond(0.8, 0.1, 0.5, -0.3).normalized();
    view.cam_from_world.translation = view.cam_from_world.rotation * -centre;
    views.push_back(view);
  }
  GaussianModel model;
  for (const Points& part : parts) {
    for (const Eigen::Vector3d& point : part) {
      const size_t at = model.size();
      model.Resize(at + 1);
      for (int axis = 0; axis < 3; ++axis) {
        model.means[3 * at + axis] = static_cast<float>(point[axis]);
      }
    }
  }
  return ChooseImportanceMetric(views, model);
}

TEST(ChooseImportanceMetricTest, ObjectInsideARing) {
  const Points object = InBox(2000, {-0.4, -0.4, -0.4}, {0.4, 0.4, 0.4}, 0);
  EXPECT_EQ(Choice(Ring(40, 2), {object}), ImportanceMetric::kIndoor);
  // In a room of 8 m.
  const Points room = OnWalls(3000, {-4, -1.5, -4}, {4, 1, 4}, 1);
  EXPECT_EQ(Choice(Ring(40, 2), {object, room}), ImportanceMetric::kIndoor);
  // With some floaters and a stray camera very far away.
  Points ring = Ring(40, 2);
  ring.push_back({1e5, 0, 0});
  EXPECT_EQ(Choice(ring, {object, room, Background(250, 10, 1000)}),
            ImportanceMetric::kIndoor);
  // Under the open sky.
  EXPECT_EQ(Choice(ring, {object, Background(700, 5, 300)}),
            ImportanceMetric::kOutdoor);
}

TEST(ChooseImportanceMetricTest, RoomAroundTheCameras) {
  const Points room = OnWalls(5000, {-3, -1.5, -2.5}, {3, 1, 2.5}, 2);
  EXPECT_EQ(Choice(InBox(60, {-2, -0.5, -2}, {2, 0, 2}, 3), {room}),
            ImportanceMetric::kIndoor);
  // All from one place, and from one tripod exactly.
  EXPECT_EQ(Choice(Ring(30, 0.05), {room}), ImportanceMetric::kIndoor);
  EXPECT_EQ(Choice(Points(9, Eigen::Vector3d(0, 0, 0)), {room}),
            ImportanceMetric::kIndoor);
}

TEST(ChooseImportanceMetricTest, StreetWithFarBackground) {
  const Points street = OnWalls(4000, {-6, -8, -20}, {6, 1.5, 20}, 4);
  const Points background = Background(1500, 30, 1000);
  const Points walk = InBox(50, {-1, -0.1, -10}, {1, 0.1, 10}, 5);
  EXPECT_EQ(Choice(walk, {street, background}), ImportanceMetric::kOutdoor);
  EXPECT_EQ(Choice(walk, {street}), ImportanceMetric::kIndoor);
  // Without walking.
  EXPECT_EQ(Choice(Ring(20, 0.2), {street, background}),
            ImportanceMetric::kOutdoor);
}

TEST(ChooseImportanceMetricTest, NothingToChooseFrom) {
  EXPECT_EQ(Choice({}, {}), ImportanceMetric::kIndoor);
  EXPECT_EQ(Choice({}, {Background(10, 1, 1000)}), ImportanceMetric::kIndoor);
  EXPECT_EQ(Choice(Ring(4, 1), {}), ImportanceMetric::kIndoor);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(Choice(Ring(4, 1), {Points(3, Eigen::Vector3d(nan, 0, 0))}),
            ImportanceMetric::kIndoor);
}

}  // namespace
}  // namespace freegs::splat
