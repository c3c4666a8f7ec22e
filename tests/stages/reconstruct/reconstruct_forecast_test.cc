// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/reconstruct_forecast.h"

#include <gtest/gtest.h>

#include "tests/stages/scene_outlook_of.h"

namespace freegs::stages {
namespace {

using pipeline::SceneOutlook;
using pipeline::StageNeed;

constexpr int64_t kMillion = 1'000'000;

splat::TrainerOptions Training(const ReconstructStageOptions& options,
                               const SceneOutlook& scene) {
  return *MakeTrainerOptions(
      options,
      pipeline::CountPixels(scene.train, options.max_image_size).total,
      int64_t{16} * 1000 * kMillion,
      0);
}

StageNeed Need(const ReconstructStageOptions& options,
               SceneOutlook scene,
               int threads = 2) {
  return ReconstructNeed(options, Training(options, scene), threads, &scene);
}

TEST(ReconstructForecastTest, GrowsWithTheScene) {
  ReconstructStageOptions options;
  options.budget = "50000";
  const StageNeed some = Need(options, SceneOutlookOf(24, 640, 480));
  EXPECT_GT(some.memory_bytes, pipeline::kProgramMemory);
  EXPECT_GT(Need(options, SceneOutlookOf(48, 640, 480)).memory_bytes,
            some.memory_bytes);
  const StageNeed large = Need(options, SceneOutlookOf(24, 800, 600));
  EXPECT_GT(large.memory_bytes, some.memory_bytes);
  EXPECT_GT(large.disk_bytes, some.disk_bytes);
  EXPECT_GT(large.seconds, some.seconds);
  EXPECT_LT(Need(options, SceneOutlookOf(24, 640, 480), 4).seconds,
            some.seconds);
  // Huge photos, which are read on each thread.
  const SceneOutlook huge = SceneOutlookOf(24, 12000, 9000);
  EXPECT_GT(Need(options, huge).memory_bytes, large.memory_bytes);
  EXPECT_GT(Need(options, huge, 8).memory_bytes,
            Need(options, huge).memory_bytes);
  options.budget = "100000";
  const StageNeed dense = Need(options, SceneOutlookOf(24, 640, 480));
  EXPECT_GT(dense.memory_bytes, some.memory_bytes);
  EXPECT_GT(dense.disk_bytes, some.disk_bytes);
  EXPECT_GT(dense.seconds, some.seconds);
}

TEST(ReconstructForecastTest, PhotosBeyondTheCacheTakeNone) {
  ReconstructStageOptions options;
  options.budget = "50000";
  options.image_cache_gb = 0.02;
  const StageNeed all = Need(options, SceneOutlookOf(65, 800, 600));
  SceneOutlook more = SceneOutlookOf(65, 800, 600);
  const std::vector<View> train = more.train;
  more.train.insert(more.train.end(), train.begin(), train.end());
  EXPECT_EQ(Need(options, more).memory_bytes, all.memory_bytes);
  more = SceneOutlookOf(65, 800, 600);
  more.holdout.resize(10, more.holdout[0]);
  EXPECT_EQ(Need(options, more).memory_bytes, all.memory_bytes);
}

TEST(ReconstructForecastTest, ReadingPhotosTakesTime) {
  ReconstructStageOptions options;
  options.budget = "50000";
  options.max_image_size = 800;
  options.image_cache_gb = 1000;
  const auto seconds = [&](int photos, int width, int height) {
    return Need(options, SceneOutlookOf(photos, width, height)).seconds;
  };
  // Photos of 24 megapixels. The steps are the same for any number of them, and
  // for smaller ones of the same shape.
  const double some = seconds(100, 6000, 4000);
  const double more = seconds(1000, 6000, 4000);
  EXPECT_GT(more, some + 900 * 0.3);
  EXPECT_LT(more, some + 900 * 0.9);
  EXPECT_GT(some, seconds(100, 3000, 2000) + 20);
  EXPECT_LT(some, seconds(100, 3000, 2000) + 70);
  // Small photos are soon read.
  EXPECT_LT(seconds(60, 640, 480), 1.01 * seconds(30, 640, 480));
  // Those that do not fit in the cache are read again, by one thread.
  options.image_cache_gb = 0.5;
  const double again = seconds(1000, 6000, 4000);
  EXPECT_GT(again, more + 0.5 * options.iterations);
  options.image_cache_gb = 1;
  EXPECT_LT(seconds(1000, 6000, 4000), again);
  options.image_cache_gb = 1000;
  // An imported scene is not trained, so only the holdout is read.
  options.import = "scene.ply";
  EXPECT_GT(seconds(1000, 6000, 4000), 125 * 0.3);
  EXPECT_LT(seconds(1000, 6000, 4000), 125 * 0.9);
}

TEST(ReconstructForecastTest, TheSparseModelTakesMemoryWhileItIsRead) {
  ReconstructStageOptions options;
  options.budget = "50000";
  options.image_cache_gb = 0.02;
  const int64_t few = Need(options, SceneOutlookOf(100, 640, 480)).memory_bytes;
  const int64_t many =
      Need(options, SceneOutlookOf(10000, 640, 480)).memory_bytes;
  EXPECT_GT(many, 2100 * kMillion);
  EXPECT_LT(few, 600 * kMillion);
}

TEST(ReconstructForecastTest, AllPhotosFitOrNeitherKindDoes) {
  EXPECT_EQ(HoldoutShareOfCache(1000, 0), 0);
  EXPECT_DOUBLE_EQ(HoldoutShareOfCache(300, 100), 0.2);
}

TEST(ReconstructForecastTest, HoldoutPhotosAndTheirPicturesTakeThreeBytesEach) {
  ReconstructStageOptions options;
  options.import = "scene.ply";
  const SceneOutlook scene = SceneOutlookOf(24, 640, 480);
  SceneOutlook more = scene;
  more.holdout.push_back(more.holdout[0]);
  const double pixels = 640 * 480;
  const auto grown = [&] {
    return static_cast<double>(Need(options, more).memory_bytes -
                               Need(options, scene).memory_bytes);
  };
  EXPECT_NEAR(grown(), 6 * pixels, 2.0);
  // While the scene is trained there are photos instead of pictures.
  options.import.clear();
  options.budget = "50000";
  EXPECT_NEAR(grown(), 3 * pixels, 2.0);
}

TEST(ReconstructForecastTest, DiskHoldsTheModelAndThreeCheckpoints) {
  ReconstructStageOptions options;
  options.densification = "none";  // Each point stays one Gaussian.
  SceneOutlook scene = SceneOutlookOf(24, 640, 480);
  scene.points = 1000;
  const int64_t few = Need(options, scene).disk_bytes;
  scene.points = 2000;
  // 38 floats a Gaussian: position, scales, rotation, opacity, 9 x 3 of colour.
  const int64_t model = 1000 * 38 * 4;
  EXPECT_EQ(Need(options, scene).disk_bytes - few,
            model + 3 * (5 * model + 1000 * 12));
}

TEST(ReconstructForecastTest, GaussiansGrowFromThePointsUpToTheBudget) {
  ReconstructStageOptions options;
  options.budget = "50000";
  options.iterations = 5000;
  options.densify_interval = 100;
  const SceneOutlook scene = SceneOutlookOf(24, 640, 480);
  const auto expected = [&](int64_t points) {
    return ExpectGaussians(Training(options, scene),
                           points,
                           pipeline::CountPixels(scene.train, 0).total);
  };
  // Mini-Splatting has twice the budget before it simplifies.
  EXPECT_EQ(expected(10000).dense, 100000);
  EXPECT_LE(expected(10000).left, 50000);
  options.densification = "gradient";
  EXPECT_EQ(expected(10000).dense, 50000);
  EXPECT_EQ(expected(10000).left, 50000);
  options.densification = "none";
  EXPECT_EQ(expected(10000).left, 10000);
  options.densification = "mini_splatting";
  EXPECT_LT(expected(1000).dense, 100000);
  options.iterations = 600;  // Densified at 100 and 200.
  EXPECT_NEAR(expected(10000).dense, 19600, 1e-6);
  // More than the budget, to begin with.
  EXPECT_EQ(expected(200000).dense, 200000);
  options.budget = "0";
  EXPECT_NEAR(expected(10000).dense, 19600, 1e-6);
  // A long training starts again from depth maps, however few the points.
  options.iterations = 20000;
  EXPECT_EQ(expected(10).dense, 21 * 640 * 480 / 32);
  options.budget = "50000";
  EXPECT_EQ(expected(10).dense, 77778);
  EXPECT_GT(expected(10).left, 20000);
}

TEST(ReconstructForecastTest, MasksTakeAByteAPixel) {
  SceneOutlook scene = SceneOutlookOf(24, 640, 480);
  const int64_t without = Need({}, scene).memory_bytes;
  scene.masks = true;
  const double pixels = 640 * 480;
  EXPECT_NEAR(static_cast<double>(Need({}, scene).memory_bytes - without),
              pixels * (21 * 4 / 3.0 + 3),
              2.0);
}

TEST(AutomaticBudgetTest, FollowsPhotosAndMemory) {
  const int64_t large = int64_t{64} * 1000 * kMillion;
  EXPECT_EQ(AutomaticBudget(15 * kMillion, large), 200000);
  EXPECT_EQ(AutomaticBudget(30 * kMillion, large), 400000);
  EXPECT_EQ(AutomaticBudget(300 * kMillion, large), 400000);
  // Ten small photos.
  EXPECT_EQ(AutomaticBudget(3 * kMillion, large), 40000);
  EXPECT_EQ(AutomaticBudget(1000, large), 5000);
  // Memory that is not known bounds nothing.
  EXPECT_EQ(AutomaticBudget(30 * kMillion, 0), 400000);
  // A machine with half a gigabyte.
  const int64_t small = AutomaticBudget(300 * kMillion, 500 * kMillion);
  EXPECT_GT(small, 100000);
  EXPECT_LT(small, 200000);
  // A number given is taken as it is.
  ReconstructStageOptions options;
  options.budget = "123";
  EXPECT_EQ(Training(options, SceneOutlookOf(9, 640, 480)).budget, 123);
  options.budget = "auto";
  const int64_t automatic =
      Training(options, SceneOutlookOf(9, 640, 480)).budget;
  options.budget = "auto:123";
  EXPECT_EQ(Training(options, SceneOutlookOf(9, 640, 480)).budget, 123);
  options.budget = "auto:1000000";
  EXPECT_EQ(Training(options, SceneOutlookOf(9, 640, 480)).budget, automatic);
}

// The more densifications there are, the sooner there are as many Gaussians as
// may be, and the longer they stay.
TEST(ReconstructForecastTest, ALongerDensePhaseTakesMore) {
  ReconstructStageOptions options;
  options.budget = "50000";
  options.max_image_size = 640;
  const SceneOutlook scene = SceneOutlookOf(24, 640, 480);
  options.densify_interval = 100;
  const double slowly = Need(options, scene).seconds;
  options.densify_interval = 25;
  EXPECT_GT(Need(options, scene).seconds, 1.02 * slowly);
}

TEST(ReconstructForecastTest, ALowerShDegreeTakesLess) {
  ReconstructStageOptions options;
  const SceneOutlook scene = SceneOutlookOf(24, 640, 480);
  const StageNeed most = Need(options, scene);
  options.sh_degree = 0;
  EXPECT_LT(Need(options, scene).memory_bytes, most.memory_bytes);
  EXPECT_LT(Need(options, scene).seconds, most.seconds);
}

TEST(ReconstructForecastTest, AnImportedModelIsNotTrained) {
  ReconstructStageOptions options;
  options.import = "scene.ply";
  SceneOutlook scene = SceneOutlookOf(24, 640, 480);
  scene.gaussians = 1000;
  const StageNeed small = Need(options, scene);
  EXPECT_GT(small.memory_bytes, pipeline::kProgramMemory);
  EXPECT_LT(small.seconds, Need({}, scene).seconds);
  scene.gaussians = kMillion;
  EXPECT_GT(Need(options, scene).memory_bytes,
            small.memory_bytes + 500 * kMillion);
  scene.gaussians = 0;
  EXPECT_FALSE(Need(options, scene).known());
}

TEST(ReconstructForecastTest, NothingIsKnownWithoutPhotosOrPoints) {
  SceneOutlook scene = SceneOutlookOf(24, 640, 480);
  scene.points = 0;
  const ReconstructStageOptions options;
  EXPECT_FALSE(
      ReconstructNeed(options, Training(options, scene), 1, &scene).known());
  EXPECT_EQ(scene.gaussians, 0);
  EXPECT_FALSE(Need(options, {}).known());
}

}  // namespace
}  // namespace freegs::stages
