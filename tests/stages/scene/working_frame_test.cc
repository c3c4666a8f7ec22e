// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/working_frame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sfm/scene/model_io.h"
#include "sfm/scene/views.h"
#include "stages/scene/workspace_scene.h"
#include "tests/stages/moved_world.h"
#include "tests/stages/synthetic_workspace.h"

namespace freegs::stages {
namespace {

using testing::HasSubstr;

TEST(WorkingFrameTest, ScenesAreTheSameInAnyUnitAndPlace) {
  const SyntheticWorkspace plain;
  RoundModel(plain.path());
  const auto expected = ReadWorkspaceScene(plain.path());
  ASSERT_TRUE(expected.ok());
  for (const double scale : {1e-3, 1.0, 1e4}) {
    for (const double sizes : {0.0, 3.0, 1e5}) {
      const SyntheticWorkspace moved;
      RoundModel(moved.path());
      const Eigen::Vector3d shift = Eigen::Vector3d(3, -2, 4) * scale * sizes;
      MoveWorld(moved.path(), scale, shift);
      const auto scene = ReadWorkspaceScene(moved.path());
      ASSERT_TRUE(scene.ok()) << scene.status().message();
      EXPECT_NEAR(
          scene->frame.unit, scale * expected->frame.unit, 1e-6 * scale);
      EXPECT_NEAR(
          (scene->frame.origin - scale * expected->frame.origin - shift).norm(),
          0,
          1e-6 * scale);
      EXPECT_EQ(scene->model.means, expected->model.means) << scale << sizes;
      EXPECT_EQ(scene->model.log_scales, expected->model.log_scales);
      ASSERT_EQ(scene->train.size(), expected->train.size());
      for (size_t k = 0; k < scene->train.size(); ++k) {
        EXPECT_NEAR((scene->train[k].cam_from_world.translation -
                     expected->train[k].cam_from_world.translation)
                        .norm(),
                    0,
                    1e-8);
      }
    }
  }
}

TEST(WorkingFrameTest, MedianDepthAndPlaceOfWhatIsSeen) {
  sfm::Reconstruction sparse;
  View view;
  view.camera = {100, 100, 100, 100, 50, 50};
  for (int k = 0; k < 5; ++k) {
    sfm::Point3D point;
    point.xyz = {0.1 * k, -0.2 * k, 8.0 + k};
    sparse.points3d.push_back(point);
  }
  sparse.points3d.push_back({});
  sparse.points3d.back().xyz = {0, 0, -500};  // Behind the camera.
  const splat::ModelFrame frame = ChooseFrame(sparse, {{view}});
  EXPECT_DOUBLE_EQ(frame.unit, 10 / splat::kTypicalDepth);
  EXPECT_DOUBLE_EQ(frame.origin.x(), 0.2);
  EXPECT_DOUBLE_EQ(frame.origin.z(), 10);
}

TEST(WorkingFrameTest, InstancesReturnToTheWorld) {
  semantics::Instance instance;
  instance.centre = {1, 2, 3};
  instance.aabb = {{0, 0, 0}, {1, 1, 1}};
  instance.obb.centre = {1, 0, 0};
  instance.obb.size = {2, 3, 4};
  const semantics::Instance world =
      InWorld({.origin = {10, 20, 30}, .unit = 0.5}, instance);
  EXPECT_EQ(world.centre, Eigen::Vector3d(10.5, 21, 31.5));
  EXPECT_EQ(world.aabb.max, Eigen::Vector3d(10.5, 20.5, 30.5));
  EXPECT_EQ(world.obb.centre, Eigen::Vector3d(10.5, 20, 30));
  EXPECT_EQ(world.obb.size, Eigen::Vector3d(1, 1.5, 2));
}

TEST(WorkingFrameTest, FarScenesSayWhatFilesHold) {
  EXPECT_EQ(FarAwayNote({{100, 0, 0}, 1}), "");
  const std::string note = FarAwayNote({{6.4e6, 0, 0}, 1});
  EXPECT_THAT(note, HasSubstr("1.3e+06 times its size"));
  EXPECT_THAT(note, HasSubstr("off by up to 0.38 units"));
  EXPECT_THAT(note, HasSubstr(".spz files count from 6400000 0 0"));
}

TEST(WorkingFrameTest, NothingVisibleIsNoResult) {
  const SyntheticWorkspace workspace;
  auto scene = ReadWorkspaceScene(workspace.path());
  ASSERT_TRUE(scene.ok());
  ThreadPool pool(2);
  EXPECT_TRUE(
      CheckVisible(scene->model, scene->train, scene->render, pool).ok());
  for (size_t k = 0; k < scene->model.means.size(); k += 3) {
    scene->model.means[k] += 1000;
  }
  const Status status =
      CheckVisible(scene->model, scene->train, scene->render, pool);
  EXPECT_EQ(status.code(), StatusCode::kUnusableResult);
  EXPECT_THAT(status.message(), HasSubstr("none of the 120 Gaussians"));
}

}  // namespace
}  // namespace freegs::stages
