// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bootstrap/bootstrap_forecast.h"

#include <gtest/gtest.h>

#include "tests/stages/scene_outlook_of.h"

namespace freegs::stages {
namespace {

using pipeline::SceneOutlook;
using pipeline::StageNeed;

constexpr int64_t kModelBytes = 12'000'000;

StageNeed Need(const BootstrapStageOptions& options,
               const SceneOutlook& scene,
               int threads = 2) {
  return BootstrapNeed(options, kModelBytes, threads, scene);
}

TEST(BootstrapForecastTest, GrowsWithTheScene) {
  SceneOutlook scene = SceneOutlookOf(12, 1600, 1200);
  const StageNeed some = Need({}, scene);
  EXPECT_GT(some.memory_bytes, pipeline::kProgramMemory);
  for (const SceneOutlook& more :
       {SceneOutlookOf(20, 1600, 1200), SceneOutlookOf(12, 3200, 2400)}) {
    EXPECT_GT(Need({}, more).memory_bytes, some.memory_bytes);
    EXPECT_GT(Need({}, more).disk_bytes, some.disk_bytes);
    EXPECT_GE(Need({}, more).seconds, some.seconds);
  }
  EXPECT_GT(Need({}, scene, 4).memory_bytes, some.memory_bytes);
  EXPECT_LT(Need({}, scene, 4).seconds, some.seconds);
  EXPECT_GT(BootstrapNeed({}, 2 * kModelBytes, 2, scene).memory_bytes,
            some.memory_bytes);
  scene.gaussians *= 2;
  EXPECT_GT(Need({}, scene).memory_bytes, some.memory_bytes);
  EXPECT_GT(Need({}, scene).seconds, some.seconds);
}

TEST(BootstrapForecastTest, WeightsKeepToTheirLimit) {
  const SceneOutlook scene = SceneOutlookOf(24, 1600, 1200);
  BootstrapStageOptions options;
  const StageNeed all = Need(options, scene);
  options.weights_memory_gb = 0.1;
  const StageNeed some = Need(options, scene);
  // The others go to the disk.
  EXPECT_LT(some.memory_bytes, all.memory_bytes);
  EXPECT_NEAR(static_cast<double>(some.disk_bytes - all.disk_bytes),
              static_cast<double>(all.memory_bytes - some.memory_bytes),
              2.0);
}

TEST(BootstrapForecastTest, WeightsTakeNoMoreDiskThanTheyMay) {
  BootstrapStageOptions options;
  options.weights_memory_gb = 0;
  const SceneOutlook scene = SceneOutlookOf(24, 1600, 1200);
  const int64_t all = Need(options, scene).disk_bytes;
  options.method.weights.max_scratch_bytes = 1'000'000;
  EXPECT_LT(Need(options, scene).disk_bytes, all);
}

TEST(BootstrapForecastTest, ModesTakeMoreAndLess) {
  const SceneOutlook scene = SceneOutlookOf(24, 1600, 1200);
  BootstrapStageOptions options;
  const StageNeed lift = Need(options, scene);
  options.mode = "paper";
  EXPECT_GT(Need(options, scene).memory_bytes, lift.memory_bytes);
  EXPECT_GT(Need(options, scene).seconds, lift.seconds);
  options.mode = "geometry";
  EXPECT_LT(Need(options, scene).memory_bytes, lift.memory_bytes);
}

// However few of the photos teach, each gets a map of its instances.
TEST(BootstrapForecastTest, MapsTakeTimeForEachPhoto) {
  BootstrapStageOptions options;
  options.mode = "geometry";
  const auto seconds = [&options](int photos, int width, int height) {
    return Need(options, SceneOutlookOf(photos, width, height)).seconds;
  };
  EXPECT_GT(seconds(2400, 1600, 1066), 5 * seconds(240, 1600, 1066));
  EXPECT_GT(seconds(2400, 6000, 4000), 5 * seconds(2400, 1600, 1066));
  // In small scenes they are a small part.
  EXPECT_LT(seconds(80, 640, 480), 1.3 * seconds(40, 640, 480));
  // Two threads take little more than half of the time of one.
  const auto maps = [&options](int threads) {
    return Need(options, SceneOutlookOf(2400, 1600, 1066), threads).seconds -
           Need(options, SceneOutlookOf(240, 1600, 1066), threads).seconds;
  };
  EXPECT_NEAR(maps(2) / maps(1), 0.55, 0.01);
}

TEST(BootstrapForecastTest, TrainingTakesTimeForEachPhotoAndClustering) {
  const SceneOutlook scene = SceneOutlookOf(40, 480, 360);
  BootstrapStageOptions options;
  const auto seconds = [&options](const SceneOutlook& of) {
    return Need(options, of).seconds;
  };
  const double lift = seconds(scene);
  // An average needs no more photos, but training takes all. The maps of
  // instances are few.
  EXPECT_LT(seconds(SceneOutlookOf(80, 480, 360)), 1.1 * lift);
  options.mode = "paper";
  options.method.training.iterations = 60;
  const double few_steps = seconds(scene);
  EXPECT_GT(few_steps, 2 * lift);  // The clustering at the end.
  EXPECT_GT(seconds(SceneOutlookOf(80, 480, 360)), 1.5 * few_steps);
  // Two more clusterings. The second one ends training, so that further steps
  // are not taken.
  options.method.training.iterations = 5001;
  const double clustered = seconds(scene);
  EXPECT_GT(clustered, 2.5 * few_steps);
  options.method.training.iterations = 20000;
  EXPECT_DOUBLE_EQ(seconds(scene), clustered);
  // So it is in the union space, unless semantics are part of it.
  options.clustering = "union";
  EXPECT_DOUBLE_EQ(seconds(scene), clustered);
  options.method.clustering.union_space.space.semantic_weight = 0.1;
  EXPECT_GT(seconds(scene), 2 * clustered);
  options.method.training.cluster_start = 0;
  EXPECT_LT(seconds(scene), 3 * clustered);
}

TEST(BootstrapForecastTest, ManyNeighboursTakeMore) {
  const SceneOutlook scene = SceneOutlookOf(24, 640, 480);
  BootstrapStageOptions options;
  int& min_samples = options.method.clustering.union_space.hdbscan.min_samples;
  const int64_t without = Need(options, scene).memory_bytes;
  min_samples = 2000;
  EXPECT_EQ(Need(options, scene).memory_bytes, without);
  options.clustering = "union";
  EXPECT_GE(Need(options, scene).memory_bytes,
            without + 8000 * scene.gaussians);
}

TEST(BootstrapForecastTest, LongVectorsTakeMore) {
  const SceneOutlook scene = SceneOutlookOf(24, 640, 480);
  for (const char* mode : {"lift", "paper"}) {
    BootstrapStageOptions options;
    options.mode = mode;
    options.method.features.dim = 128;
    const StageNeed usual = Need(options, scene);
    options.method.features.dim = 512;
    const StageNeed more = Need(options, scene);
    EXPECT_GT(more.memory_bytes, usual.memory_bytes) << mode;
    EXPECT_GT(more.disk_bytes, usual.disk_bytes) << mode;
    EXPECT_GE(more.seconds, usual.seconds) << mode;
    options.method.features.dim = 8;
    EXPECT_LE(Need(options, scene).memory_bytes, usual.memory_bytes) << mode;
  }
  BootstrapStageOptions options;
  options.mode = "paper";
  const double chosen = Need(options, scene).seconds;
  options.method.features.dim = 128;
  EXPECT_GT(Need(options, scene).seconds, 1.5 * chosen);
}

TEST(BootstrapForecastTest, TrainingTakesMemoryForEachNumberAndPhoto) {
  SceneOutlook scene = SceneOutlookOf(40, 640, 480);
  BootstrapStageOptions options;
  options.mode = "paper";
  options.weights_memory_gb = 0;
  const auto bytes = [&options](const SceneOutlook& of) {
    return Need(options, of).memory_bytes;
  };
  EXPECT_GE(bytes(SceneOutlookOf(80, 640, 480)),
            bytes(scene) + int64_t{35} * 1'200'000);
  for (const int dim : {128, 512}) {
    options.method.features.dim = dim;
    const int64_t some = bytes(scene);
    const int64_t gaussians = scene.gaussians;
    scene.gaussians *= 2;
    const int64_t per_gaussian = (bytes(scene) - some) / gaussians;
    scene.gaussians = gaussians;
    // The number, its gradient and two moments, and the number and its moments
    // twice more while a checkpoint is written.
    EXPECT_GE(per_gaussian, 10 * 4 * dim) << dim;
    EXPECT_LE(per_gaussian, 1.25 * 10 * 4 * dim) << dim;
  }
}

TEST(BootstrapForecastTest, NothingIsKnownWithoutPhotosOrGaussians) {
  SceneOutlook scene = SceneOutlookOf(24, 640, 480);
  scene.gaussians = 0;
  EXPECT_FALSE(Need({}, scene).known());
  scene = {};
  scene.gaussians = 7;
  EXPECT_FALSE(Need({}, scene).known());
}

}  // namespace
}  // namespace freegs::stages
