// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/geometry/scene_extent.h"

#include <vector>

#include <gtest/gtest.h>

#include "tests/semantics/synthetic_gaussians.h"

namespace freegs::semantics {
namespace {

TEST(SceneExtentTest, IgnoresFarPoints) {
  std::vector<float> positions;
  for (int i = -50; i <= 50; ++i) {
    for (const float x : {3.0f + 0.02f * static_cast<float>(i), 1.0f, -2.0f}) {
      positions.push_back(x);
    }
  }
  const SceneExtent clean = ComputeSceneExtent(positions);
  EXPECT_NEAR(clean.centre.x(), 3, 1e-6);
  EXPECT_NEAR(clean.radius, 0.5, 0.02);
  for (int i = 0; i < 5; ++i) {
    for (const float x : {1e6f, 1e6f, 1e6f}) positions.push_back(x);
  }
  EXPECT_NEAR(ComputeSceneExtent(positions).radius, clean.radius, 0.05);
}

TEST(SceneExtentTest, PositionsOfNothingAndOfOnePoint) {
  EXPECT_EQ(ComputeSceneExtent({}).radius, 1);
  const std::vector<float> point = {4, 5, 6};
  EXPECT_EQ(ComputeSceneExtent(point).radius, 1);
  EXPECT_EQ(ComputeSceneExtent(point).centre, Eigen::Vector3d(4, 5, 6));
}

TEST(SceneExtentTest, ViewsTellTheSubjectFromItsSurroundings) {
  SyntheticGaussians scene = MakeTableScene();
  // A far backdrop of more Gaussians than the table has.
  for (int i = 0; i < 30000; ++i) {
    scene.Add({60 * scene.Uniform() - 30, 60 * scene.Uniform() - 30, -20},
              {0.5, 0.5, 0.5},
              0.1,
              0.9,
              -1);
  }
  std::vector<View> views;
  for (int i = 0; i < 5; ++i) views.push_back(LookAtOrigin(1.2 * i));
  ThreadPool pool(2);
  const SceneExtent extent = ComputeSceneExtent(scene.model, views, 0.1, pool);
  EXPECT_NEAR(extent.radius, 1.4, 0.2);
  EXPECT_LT(extent.centre.norm(), 0.2);
  // The positions alone say otherwise.
  EXPECT_GT(ComputeSceneExtent(scene.model, {}, 0.1, pool).radius, 5);
}

}  // namespace
}  // namespace freegs::semantics
