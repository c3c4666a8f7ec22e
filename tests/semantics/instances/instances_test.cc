// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/instances.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/semantics/synthetic_gaussians.h"

namespace freegs::semantics {
namespace {

// The surface of an upright box turned by 25 degrees, and strays.
SyntheticGaussians MakeBox(const OrientedBox& box, int num_strays) {
  SyntheticGaussians scene;
  for (int i = 0; i < 6000; ++i) {
    Eigen::Vector3d x(
        scene.Uniform() - 0.5, scene.Uniform() - 0.5, scene.Uniform() - 0.5);
    x[i % 3] = i % 2 == 0 ? 0.5 : -0.5;
    scene.Add(box.centre + box.rotation * x.cwiseProduct(box.size),
              {0.5, 0.5, 0.5},
              0.002,
              0.9,
              0);
  }
  for (int i = 0; i < num_strays; ++i) {
    scene.Add({8 * scene.Uniform() - 4, 8 * scene.Uniform() - 4, 4.0},
              {0.5, 0.5, 0.5},
              0.002,
              0.9,
              0);
  }
  return scene;
}

OrientedBox TrueBox() {
  OrientedBox box;
  box.centre = {0.5, -0.2, 1};
  box.size = {0.6, 0.3, 0.4};
  box.rotation =
      Eigen::AngleAxisd(25 * std::numbers::pi / 180, Eigen::Vector3d::UnitZ())
          .toRotationMatrix();
  return box;
}

// The IoU of two boxes, by counting points of the first that are in the second.
double CountedIou(const OrientedBox& a, const OrientedBox& b) {
  constexpr int kPoints = 50000;
  RandomStream random(9, 1);
  int both = 0;
  for (int k = 0; k < kPoints; ++k) {
    const Eigen::Vector3d at(
        random.Uniform() - 0.5, random.Uniform() - 0.5, random.Uniform() - 0.5);
    const Eigen::Vector3d point =
        a.centre + a.rotation * a.size.cwiseProduct(at);
    const Eigen::Vector3d in_b = b.rotation.transpose() * (point - b.centre);
    both += (in_b.cwiseAbs() - 0.5 * b.size).maxCoeff() <= 0;
  }
  const double shared = a.size.prod() * both / kPoints;
  return shared / (a.size.prod() + b.size.prod() - shared);
}

TEST(InstancesTest, UprightBoxIgnoresStrays) {
  const OrientedBox truth = TrueBox();
  const SyntheticGaussians scene = MakeBox(truth, 40);
  ThreadPool pool(2);
  const std::vector<Instance> instances =
      BuildInstances(scene.model,
                     scene.truth,
                     1,
                     std::vector<double>{0.5},
                     std::vector<uint8_t>{1},
                     Eigen::Vector3d(0, 0, 1),
                     {},
                     pool);
  ASSERT_EQ(instances.size(), 1u);
  const Instance& instance = instances[0];
  EXPECT_EQ(instance.id, 1);
  EXPECT_EQ(instance.num_gaussians, 6040);
  EXPECT_EQ(instance.score, 0.5);
  EXPECT_TRUE(instance.background);
  EXPECT_GT(CountedIou(instance.obb, truth), 0.93);
  EXPECT_LT((instance.centre - truth.centre).norm(), 0.01);
  EXPECT_NEAR(instance.obb.rotation.determinant(), 1, 1e-9);
  EXPECT_NEAR(instance.aabb.max.z(), 1.2, 0.01);
  EXPECT_NEAR(instance.aabb.min.z(), 0.8, 0.01);
}

TEST(InstancesTest, PrincipalAxesWithoutAVertical) {
  OrientedBox truth = TrueBox();
  truth.rotation = Eigen::AngleAxisd(0.9, Eigen::Vector3d(1, 2, 3).normalized())
                       .toRotationMatrix();
  truth.size = {0.9, 0.2, 0.5};
  const SyntheticGaussians scene = MakeBox(truth, 0);
  ThreadPool pool(1);
  const std::vector<Instance> instances = BuildInstances(
      scene.model, scene.truth, 1, {}, {}, std::nullopt, {}, pool);
  EXPECT_GT(CountedIou(instances[0].obb, truth), 0.85);
  EXPECT_NEAR(instances[0].obb.rotation.determinant(), 1, 1e-9);
}

TEST(InstancesTest, LabelsWithFewOrNoMembers) {
  SyntheticGaussians scene;
  scene.Add({1, 2, 3}, {0, 0, 0}, 0.1, 0.05, 1);
  scene.Add({std::nan(""), 2, 3}, {0, 0, 0}, 0.1, 0.9, 2);
  scene.Add({5, 5, 5}, {0, 0, 0}, 0.1, 0.9, -1);
  ThreadPool pool(1);
  const std::vector<Instance> instances = BuildInstances(
      scene.model, scene.truth, 3, {}, {}, Eigen::Vector3d(0, 0, 1), {}, pool);
  ASSERT_EQ(instances.size(), 3u);
  EXPECT_EQ(instances[0].num_gaussians, 0);
  // Faint, but all there is.
  EXPECT_LT((instances[1].centre - Eigen::Vector3d(1, 2, 3)).norm(), 1e-6);
  EXPECT_LT((instances[1].obb.size - Eigen::Vector3d::Constant(0.2)).norm(),
            1e-6);
  EXPECT_EQ(instances[2].num_gaussians, 1);
  EXPECT_TRUE(instances[2].centre.allFinite());
}

TEST(InstancesTest, ABoxHoldsALongGaussianAsItIsTurned) {
  SyntheticGaussians scene;
  scene.Add({1, 2, 3}, {0, 0, 0}, 0.1, 0.9, 0);
  scene.model.log_scales[0] = std::log(0.4f);
  constexpr double kTurn = std::numbers::pi / 6;  // About z.
  scene.model.rotations = {static_cast<float>(std::cos(kTurn / 2)),
                           0,
                           0,
                           static_cast<float>(std::sin(kTurn / 2))};
  ThreadPool pool(1);
  const auto instances = BuildInstances(scene.model,
                                        scene.truth,
                                        1,
                                        {},
                                        {},
                                        Eigen::Vector3d(0, 0, 1),
                                        InstanceBoxOptions(),
                                        pool);
  ASSERT_EQ(instances.size(), 1u);
  const OrientedBox& box = instances[0].obb;
  const int longer = box.size[0] > box.size[1] ? 0 : 1;
  EXPECT_NEAR(box.size[longer], 0.8, 1e-4);
  const Eigen::Vector3d along(std::cos(kTurn), std::sin(kTurn), 0);
  EXPECT_NEAR(std::abs(box.rotation.col(longer).dot(along)), 1, 1e-4);
}

View LevelView(double heading, double pitch) {
  View view;
  // Camera axes in a world with z up: x right, y down, z forward.
  Eigen::Matrix3d cam_from_world;
  cam_from_world << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  view.cam_from_world.rotation = Eigen::Quaterniond(
      Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitX()).toRotationMatrix() *
      cam_from_world *
      Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()).toRotationMatrix());
  return view;
}

TEST(InstancesTest, VerticalComesFromCamerasAndAPlane) {
  std::vector<View> views;
  for (int i = 0; i < 5; ++i) views.push_back(LevelView(0.5 * i, -0.6));
  const auto rough = EstimateVertical(views, {});
  ASSERT_TRUE(rough.has_value());
  EXPECT_GT(rough->z(), 0.7);
  std::vector<Plane> planes(2);
  planes[0].normal = Eigen::Vector3d(1, 0, 0);
  planes[1].normal = Eigen::Vector3d(0, 0, -1);
  const auto exact = EstimateVertical(views, planes);
  ASSERT_TRUE(exact.has_value());
  EXPECT_NEAR(exact->z(), 1, 1e-12);
}

// All photos are taken from one side, and look down.
TEST(InstancesTest, VerticalIsThatOfLevelCameras) {
  std::vector<View> views;
  for (const double heading : {-0.6, -0.3, 0.0, 0.3, 0.6}) {
    views.push_back(LevelView(heading, -0.8));
  }
  EXPECT_GT(EstimateVertical(views, {})->z(), 0.98);
  std::vector<Plane> floor(1);
  floor[0].normal = Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(EstimateVertical(views, floor)->z(), 1, 1e-12);
  // A camera that was held on its side changes little.
  views.push_back(LevelView(0, -0.8));
  views.back().cam_from_world.rotation =
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()) *
      views.back().cam_from_world.rotation;
  EXPECT_GT(EstimateVertical(views, {})->z(), 0.98);
  // From above, where the mean of the cameras leans by as much as they look
  // down.
  views.clear();
  for (int k = -20; k <= 20; ++k) views.push_back(LevelView(0.075 * k, -1.2));
  EXPECT_GT(EstimateVertical(views, {})->z(), 0.999);
  // Where the x axes are parallel they say nothing of how cameras are pitched.
  views = {LevelView(0, -0.3), LevelView(0, -0.3)};
  EXPECT_NEAR(EstimateVertical(views, {})->z(), std::cos(0.3), 1e-6);
}

TEST(InstancesTest, VerticalOfBoxesIsThatOfTheFloor) {
  std::vector<View> views;
  for (int i = 0; i < 3; ++i) views.push_back(LevelView(0.01 * i, -0.4));
  EXPECT_LT(VerticalOfBoxes(views, {})->z(), 0.95);
  std::vector<Instance> instances(1);
  const Eigen::Matrix3d turned =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  instances[0].obb.rotation.col(0) = turned.col(0);
  instances[0].obb.rotation.col(1) = -turned.col(2);  // Downwards.
  instances[0].obb.rotation.col(2) = turned.col(1);
  EXPECT_NEAR(VerticalOfBoxes(views, instances)->z(), 1, 1e-12);
  // A box that leans too much says nothing.
  instances[0].obb.rotation =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(-1, 1, 0).normalized())
          .toRotationMatrix();
  EXPECT_EQ(VerticalOfBoxes(views, instances), EstimateVertical(views, {}));
}

TEST(InstancesTest, NoVerticalWithoutAgreement) {
  EXPECT_FALSE(EstimateVertical({}, {}).has_value());
  std::vector<View> views = {LevelView(0, 0), LevelView(0, std::numbers::pi)};
  EXPECT_FALSE(EstimateVertical(views, {}).has_value());
}

}  // namespace
}  // namespace freegs::semantics
