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
