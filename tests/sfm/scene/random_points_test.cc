// SPDX-License-Identifier: BSD-3-Clause
// Random start points lie where the cameras look.

#include "sfm/scene/random_points.h"

#include <gtest/gtest.h>

#include "tests/sfm/synthetic_model.h"

namespace freegs::sfm {
namespace {

TEST(EstimateFocus, CamerasAroundAnObject) {
  const SceneFocus focus = EstimateFocus(SyntheticModel(12, 0));
  EXPECT_LT(focus.centre.norm(), 0.05);
  EXPECT_NEAR(focus.distance, 4.5, 0.5);
}

TEST(EstimateFocus, ParallelCamerasLookForward) {
  Reconstruction model = SyntheticModel(6, 0);
  for (int i = 0; i < 6; ++i) {
    model.images[i].cam_from_world = LookAt({0.2 * i, 0, 0}, {0.2 * i, 100, 0});
  }
  const SceneFocus focus = EstimateFocus(model);
  EXPECT_TRUE(focus.centre.allFinite());
  EXPECT_GT(focus.centre.y(), 0);
  EXPECT_GT(focus.distance, 0);
}

TEST(RandomPoints, AllAreSeenAndRepeatable) {
  const Reconstruction model = SyntheticModel(8, 0);
  const auto points = RandomPoints(model, 500, 3);
  ASSERT_TRUE(points.ok());
  ASSERT_EQ(points->size(), 500u);
  for (size_t i = 0; i < points->size(); ++i) {
    const Point3D& point = (*points)[i];
    EXPECT_EQ(point.id, i + 1);
    bool seen = false;
    for (const PosedImage& image : model.images) {
      const auto pixel =
          Project(model.cameras[0], image.cam_from_world * point.xyz);
      // Distortion moves random pixels a little.
      seen |= pixel && pixel->x() > -20 && pixel->x() < 660 &&
              pixel->y() > -20 && pixel->y() < 500;
    }
    EXPECT_TRUE(seen) << point.xyz.transpose();
  }
  const auto again = RandomPoints(model, 500, 3);
  const auto longer = RandomPoints(model, 600, 3);
  const auto other = RandomPoints(model, 500, 4);
  for (size_t i = 0; i < 500; ++i) {
    EXPECT_EQ((*points)[i].xyz, (*again)[i].xyz);
    EXPECT_EQ((*points)[i].xyz, (*longer)[i].xyz);
    EXPECT_NE((*points)[i].xyz, (*other)[i].xyz);
  }
}

TEST(RandomPoints, OneCameraIsEnoughNoneIsNot) {
  EXPECT_TRUE(RandomPoints(SyntheticModel(1, 0), 10, 0).ok());
  EXPECT_FALSE(RandomPoints(SyntheticModel(0, 0), 10, 0).ok());
}

}  // namespace
}  // namespace freegs::sfm
