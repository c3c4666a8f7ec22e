// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/scene/track_filter.h"

#include <gtest/gtest.h>

#include "tests/sfm/synthetic_model.h"

namespace freegs::sfm {
namespace {

TEST(FilterTracks, KeepsAGoodModelAndSetsErrors) {
  Reconstruction model = SyntheticModel(5, 20);
  EXPECT_EQ(FilterTracks(&model), 0u);
  ASSERT_EQ(model.points3d.size(), 20u);
  EXPECT_NEAR(model.points3d[0].error, 0, 1e-9);
}

TEST(FilterTracks, RemovesWhatIsFarOff) {
  Reconstruction model = SyntheticModel(5, 20);
  const auto feature = [&](size_t point, size_t k) -> Point2D& {
    const TrackElement& element = model.points3d[point].track[k];
    return model.images[element.image_id - 1].points2d[element.point2d_index];
  };
  feature(3, 1).xy.x() += 5;
  feature(3, 2).xy.x() += 3;
  for (size_t k = 0; k < 4; ++k) feature(7, k).xy.y() += 100;
  const uint64_t lost = model.points3d[7].id;
  EXPECT_EQ(FilterTracks(&model), 6u);
  ASSERT_EQ(model.points3d.size(), 19u);
  EXPECT_EQ(model.points3d[3].track.size(), 4u);
  EXPECT_NEAR(model.points3d[3].error, 0.75, 1e-9);
  for (const Point3D& point : model.points3d) EXPECT_NE(point.id, lost);
  EXPECT_EQ(RemoveDanglingReferences(&model), 0u);
}

TEST(FilterTracks, RemovesPointsWithoutDepthOrBehindCameras) {
  Reconstruction model = SyntheticModel(2, 20);
  // Two cameras in nearly one place.
  model.images[1].cam_from_world = model.images[0].cam_from_world;
  model.images[1].cam_from_world.translation.x() += 0.001;
  model.images[1].points2d = model.images[0].points2d;
  EXPECT_EQ(FilterTracks(&model), 40u);
  EXPECT_TRUE(model.points3d.empty());

  model = SyntheticModel(5, 20);
  model.images[2].cam_from_world.translation.z() = -100;
  EXPECT_EQ(FilterTracks(&model), 20u);
  EXPECT_EQ(model.points3d.size(), 20u);
}

}  // namespace
}  // namespace freegs::sfm
