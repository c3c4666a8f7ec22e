// SPDX-License-Identifier: BSD-3-Clause
// Consistency and parts of reconstructions.

#include "sfm/scene/reconstruction.h"

#include <gtest/gtest.h>

#include "tests/sfm/synthetic_model.h"

namespace freegs::sfm {
namespace {

TEST(RemoveDanglingReferences, KeepsConsistentModels) {
  Reconstruction model = SyntheticModel(4, 10);
  ASSERT_TRUE(CheckReconstruction(model).ok());
  EXPECT_EQ(RemoveDanglingReferences(&model), 0u);
  EXPECT_EQ(model.points3d[0].track.size(), 4u);
}

TEST(RemoveDanglingReferences, RemovesBothDirections) {
  Reconstruction model = SyntheticModel(4, 10);
  model.points3d[0].track.push_back({99, 0});      // No such image.
  model.points3d[0].track.push_back({1, 100000});  // No such feature.
  model.points3d[1].track.push_back({1, 0});       // Another point's feature.
  model.points3d[2].track.push_back(model.points3d[2].track[0]);  // Twice.
  model.images[0].points2d.back().point3d_id = 12345;  // No such point.
  EXPECT_EQ(RemoveDanglingReferences(&model), 5u);
  EXPECT_EQ(RemoveDanglingReferences(&model), 0u);
  EXPECT_EQ(model.points3d[0].track.size(), 4u);
}

TEST(RemoveDanglingReferences, PointsThatWereRemoved) {
  Reconstruction model = SyntheticModel(2, 3);
  model.points3d.clear();
  EXPECT_EQ(RemoveDanglingReferences(&model), 6u);
  for (const Point2D& point : model.images[0].points2d) {
    EXPECT_EQ(point.point3d_id, kNoPoint3D);
  }
}

TEST(RestrictTo, KeepsWhatTwoPhotosSee) {
  Reconstruction model = SyntheticModel(4, 40);
  // One point that only one photo of the part sees.
  model.points3d[0].track = {model.points3d[0].track[0],
                             model.points3d[0].track[3]};
  RemoveDanglingReferences(&model);
  Reconstruction part = RestrictTo(model, {1, 2});
  EXPECT_EQ(part.images.size(), 2u);
  EXPECT_EQ(part.points3d.size(), 39u);
  EXPECT_TRUE(CheckReconstruction(part).ok());
  EXPECT_EQ(RemoveDanglingReferences(&part), 0u);
}

}  // namespace
}  // namespace freegs::sfm
