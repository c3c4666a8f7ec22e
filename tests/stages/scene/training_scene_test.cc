// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/training_scene.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sfm/scene/model_io.h"
#include "tests/stages/synthetic_workspace.h"

namespace freegs::stages {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

// A point that two of the photos see.
void AddPoint(const std::filesystem::path& sparse) {
  StatusOr<sfm::Reconstruction> model = sfm::ReadModel(sparse);
  ASSERT_TRUE(model.ok()) << model.status().message();
  sfm::Point3D point;
  point.id = 1;
  point.xyz = {0.5, 0.25, 3};
  point.rgb = {1, 2, 3};
  for (sfm::PosedImage* image : {&model->images[0], &model->images[1]}) {
    point.track.push_back(
        {image->id, static_cast<uint32_t>(image->points2d.size())});
    image->points2d.push_back({{10, 20}, point.id});
  }
  model->points3d.push_back(point);
  ASSERT_TRUE(sfm::WriteModel(sparse, *model).ok());
}

TEST(TrainingSceneTest, HasThePointsWithoutTheSparseModel) {
  const SyntheticWorkspace workspace;
  AddPoint(workspace / "undistort/sparse");
  const StatusOr<PosedPhotos> posed = ReadPosedPhotos(workspace.path());
  ASSERT_TRUE(posed.ok()) << posed.status().message();
  EXPECT_THAT(posed->sparse.images, SizeIs(6));
  ASSERT_THAT(posed->sparse.points3d, SizeIs(1));
  const StatusOr<TrainingScene> scene = ReadTrainingScene(workspace.path());
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_THAT(scene->photos.train, SizeIs(4));
  EXPECT_THAT(scene->photos.holdout, SizeIs(2));
  EXPECT_THAT(scene->points, ElementsAre(posed->sparse.points3d[0].xyz));
  EXPECT_THAT(scene->colors, ElementsAre(posed->sparse.points3d[0].rgb));
  EXPECT_GT(scene->extent, 0);
  EXPECT_THAT(scene->photos.sparse.cameras, IsEmpty());
  EXPECT_THAT(scene->photos.sparse.images, IsEmpty());
  EXPECT_THAT(scene->photos.sparse.points3d, IsEmpty());
}

}  // namespace
}  // namespace freegs::stages
