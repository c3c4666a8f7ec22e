// SPDX-License-Identifier: BSD-3-Clause

#include "stages/sfm/sfm_forecast.h"

#include <gtest/gtest.h>

#include "sfm/scene/model_io.h"
#include "stages/sfm/sfm_stage.h"
#include "stages/sfm/undistort_stage.h"
#include "tests/sfm/synthetic_model.h"
#include "tests/stages/scene_outlook_of.h"
#include "tests/stages/sfm_workspace.h"

namespace freegs::stages {
namespace {

using pipeline::SceneOutlook;
using pipeline::StageNeed;

StageNeed Sfm(const sfm::SfmOptions& options, SceneOutlook scene, int threads) {
  return SfmNeed(options, threads, &scene);
}

TEST(SfmForecastTest, GrowsWithPixelsAndThreads) {
  sfm::SfmOptions options;
  const StageNeed some = Sfm(options, SceneOutlookOf(10, 640, 480), 2);
  const StageNeed large = Sfm(options, SceneOutlookOf(10, 800, 600), 2);
  EXPECT_GT(large.memory_bytes, some.memory_bytes);
  EXPECT_GT(large.seconds, some.seconds);
  const StageNeed threads = Sfm(options, SceneOutlookOf(10, 640, 480), 4);
  EXPECT_GT(threads.memory_bytes, some.memory_bytes);
  EXPECT_LT(threads.seconds, some.seconds);
  // Larger images than features are taken from are reduced, but read first.
  options.max_image_size = 640;
  EXPECT_EQ(Sfm(options, SceneOutlookOf(10, 2560, 1920), 2).memory_bytes,
            some.memory_bytes);
  EXPECT_GT(Sfm(options, SceneOutlookOf(10, 6400, 4800), 2).memory_bytes,
            some.memory_bytes);
  options.max_image_size = 1280;
  EXPECT_GT(Sfm(options, SceneOutlookOf(10, 2560, 1920), 2).memory_bytes,
            some.memory_bytes);
}

TEST(SfmForecastTest, GrowsWithPhotosAndFeatures) {
  sfm::SfmOptions options;
  SceneOutlook scene = SceneOutlookOf(300, 640, 480);
  const StageNeed some = SfmNeed(options, 1, &scene);
  const int64_t points = scene.points;
  EXPECT_GT(points, 1000);
  scene = SceneOutlookOf(600, 640, 480);
  const StageNeed more = SfmNeed(options, 1, &scene);
  EXPECT_GT(scene.points, points);
  EXPECT_GT(more.memory_bytes, some.memory_bytes);
  EXPECT_GT(more.disk_bytes, some.disk_bytes);
  EXPECT_GT(more.seconds, some.seconds);
  options.max_features *= 2;
  EXPECT_GT(Sfm(options, scene, 1).memory_bytes, more.memory_bytes);
}

TEST(SfmForecastTest, APartOfManyPhotosTakesLessTime) {
  sfm::SfmOptions options;
  const double part = Sfm(options, SceneOutlookOf(300, 640, 480), 1).seconds;
  options.camera_model = "RADIAL";
  EXPECT_LT(part, Sfm(options, SceneOutlookOf(300, 640, 480), 1).seconds);
  options.camera_model = "auto";
  options.fewest_for_skeleton = 301;
  EXPECT_LT(part, Sfm(options, SceneOutlookOf(300, 640, 480), 1).seconds);
}

TEST(SfmForecastTest, PairsAreAllOrThoseOfNeighbours) {
  EXPECT_EQ(ExpectedPairs({}, 40), 780);
  EXPECT_EQ(ExpectedPairs({}, 1000), 10000);
  EXPECT_EQ(ExpectedPairs({.matcher = "exhaustive"}, 1000), 499500);
  EXPECT_EQ(ExpectedPairs({.matcher = "retrieval"}, 10), 45);
}

TEST(SfmForecastTest, UndistortionGrowsWithPixelsAndCores) {
  const StageNeed some = UndistortNeed(SceneOutlookOf(10, 4000, 3000), 2, 2);
  const StageNeed large = UndistortNeed(SceneOutlookOf(10, 6000, 4000), 2, 2);
  EXPECT_GT(some.memory_bytes, pipeline::kProgramMemory);
  EXPECT_GT(large.memory_bytes, some.memory_bytes);
  EXPECT_GT(large.disk_bytes, some.disk_bytes);
  EXPECT_GT(large.seconds, some.seconds);
  const StageNeed cores = UndistortNeed(SceneOutlookOf(10, 4000, 3000), 8, 8);
  EXPECT_GT(cores.memory_bytes, some.memory_bytes);
  EXPECT_LT(cores.seconds, some.seconds);
  EXPECT_GT(UndistortNeed(SceneOutlookOf(1000, 640, 480), 2, 2).memory_bytes,
            UndistortNeed(SceneOutlookOf(10, 640, 480), 2, 2).memory_bytes);
  // Eight threads on two cores, and never more than there are photos.
  const StageNeed few = UndistortNeed(SceneOutlookOf(10, 4000, 3000), 2, 8);
  EXPECT_EQ(few.memory_bytes, cores.memory_bytes);
  EXPECT_EQ(few.seconds, some.seconds);
  EXPECT_EQ(UndistortNeed(SceneOutlookOf(8, 4000, 3000), 2, 64).memory_bytes,
            UndistortNeed(SceneOutlookOf(8, 4000, 3000), 2, 8).memory_bytes);
}

TEST(SfmForecastTest, NothingIsKnownWithoutPhotos) {
  SceneOutlook scene;
  scene.points = 3;
  EXPECT_FALSE(SfmNeed({}, 1, &scene).known());
  EXPECT_EQ(scene.points, 0);
  EXPECT_FALSE(UndistortNeed(scene, 1, 1).known());
}

// What a stage that is done leaves to the later ones is what its files say.
TEST(SfmForecastTest, StagesThatAreDoneShowTheirModels) {
  SfmWorkspace workspace(12);
  const sfm::Reconstruction model = sfm::SyntheticModel(10, 40);
  ThreadPool pool(1);
  pipeline::StageContext context;
  context.workspace = workspace.path();
  context.pool = &pool;
  const auto sfm = MakeSfmStage({}, 0);
  const auto undistort = MakeUndistortStage({.max_image_size = 320}, "colmap");
  SceneOutlook scene = SceneOutlookOf(0, 0, 0);
  for (const photos::Photo& photo : workspace.list.photos) {
    View view;
    view.name = photo.name;
    view.camera.width = 640;
    view.camera.height = 480;
    if (photo.usable()) {
      (photo.split == photos::PhotoSplit::kHoldout ? scene.holdout
                                                   : scene.train)
          .push_back(view);
    }
  }
  SceneOutlook foretold = scene;
  EXPECT_TRUE(sfm->Foretell(context, false, &foretold).known());
  EXPECT_EQ(foretold.photos(), 12);
  EXPECT_TRUE(undistort->Foretell(context, false, &foretold).known());
  EXPECT_EQ(foretold.train[0].camera.height, 240);

  for (const std::string folder : {"sfm/sparse/0", "undistort/sparse"}) {
    ASSERT_TRUE(sfm::WriteModel(workspace.path() / folder, model).ok());
  }
  EXPECT_TRUE(sfm->Foretell(context, true, &scene).known());
  EXPECT_EQ(scene.train.size(), 8u);
  EXPECT_EQ(scene.holdout.size(), 2u);
  EXPECT_EQ(scene.points, 40);
  EXPECT_TRUE(undistort->Foretell(context, true, &scene).known());
  EXPECT_EQ(scene.train.size(), 8u);
  EXPECT_EQ(scene.train[0].camera.width,
            static_cast<int>(model.cameras[0].width));

  WriteText(workspace.path() / "undistort" / "sparse" / "images.bin", "x");
  (void)undistort->Foretell(context, true, &scene);
  EXPECT_EQ(scene.photos(), 0);
}

}  // namespace
}  // namespace freegs::stages
