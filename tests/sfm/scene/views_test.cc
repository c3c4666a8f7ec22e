// SPDX-License-Identifier: BSD-3-Clause
// Views of reconstructions.

#include "sfm/scene/views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/sfm/synthetic_model.h"

namespace freegs::sfm {
namespace {

TEST(MakeViews, OrderedByName) {
  Reconstruction model = SyntheticModel(4, 5, CameraModel::kPinhole);
  std::swap(model.images[0], model.images[3]);
  const auto views = MakeViews(model);
  ASSERT_TRUE(views.ok());
  ASSERT_EQ(views->size(), 4u);
  for (int i = 0; i < 4; ++i) {
    const View& view = (*views)[i];
    EXPECT_EQ(view.name, PhotoName(i));
    const PosedImage& image = model.images[i == 0 ? 3 : i == 3 ? 0 : i];
    EXPECT_EQ(view.cam_from_world.translation,
              image.cam_from_world.translation);
    // The renderer's projection is COLMAP's.
    const Eigen::Vector3d p = view.cam_from_world * model.points3d[0].xyz;
    EXPECT_NEAR(view.camera.fx * p.x() / p.z() + view.camera.cx,
                image.points2d[0].xy.x(),
                1e-9);
    EXPECT_NEAR(view.camera.fy * p.y() / p.z() + view.camera.cy,
                image.points2d[0].xy.y(),
                1e-9);
  }
}

TEST(PinholeOf, LeavesOutTheDistortion) {
  const Camera camera = {.id = 1,
                         .model = CameraModel::kRadial,
                         .width = 640,
                         .height = 480,
                         .params = {500, 321, 239, 0.1, -0.02}};
  const Pinhole pinhole = PinholeOf(camera);
  EXPECT_EQ(pinhole.width, 640);
  EXPECT_EQ(pinhole.height, 480);
  EXPECT_EQ(pinhole.fx, 500);
  EXPECT_EQ(pinhole.fy, 500);
  EXPECT_EQ(pinhole.cx, 321);
  EXPECT_EQ(pinhole.cy, 239);
}

TEST(MakeViews, DistortionIsRefused) {
  const auto views = MakeViews(SyntheticModel(2, 2, CameraModel::kRadial));
  ASSERT_FALSE(views.ok());
  EXPECT_EQ(views.status().code(), StatusCode::kBadInput);
  EXPECT_THAT(views.status().message(), testing::HasSubstr("undistort"));
  EXPECT_TRUE(
      MakeViews(SyntheticModel(2, 2, CameraModel::kSimplePinhole)).ok());
}

}  // namespace
}  // namespace freegs::sfm
