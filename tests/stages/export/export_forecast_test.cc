// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/export_forecast.h"

#include <gtest/gtest.h>

#include "tests/stages/scene_outlook_of.h"

namespace freegs::stages {
namespace {

using pipeline::SceneOutlook;
using pipeline::StageNeed;

TEST(ExportForecastTest, GrowsWithTheScene) {
  SceneOutlook scene = SceneOutlookOf(24, 640, 480);
  const StageNeed some = ExportNeed({}, 2, scene);
  EXPECT_GT(some.memory_bytes, pipeline::kProgramMemory);
  const StageNeed large = ExportNeed({}, 2, SceneOutlookOf(24, 1280, 960));
  EXPECT_GT(large.memory_bytes, some.memory_bytes);
  EXPECT_GT(large.disk_bytes, some.disk_bytes);
  EXPECT_GT(large.seconds, some.seconds);
  EXPECT_GT(ExportNeed({}, 2, SceneOutlookOf(48, 640, 480)).seconds,
            some.seconds);
  EXPECT_GT(ExportNeed({.mask_views = 16}, 2, scene).disk_bytes,
            some.disk_bytes);
  EXPECT_LT(ExportNeed({}, 4, scene).seconds, some.seconds);
  scene.gaussians *= 2;
  const StageNeed dense = ExportNeed({}, 2, scene);
  EXPECT_GT(dense.memory_bytes, some.memory_bytes);
  EXPECT_GT(dense.disk_bytes, some.disk_bytes);
  EXPECT_GT(dense.seconds, some.seconds);
}

TEST(ExportForecastTest, NothingIsKnownWithoutPhotosOrGaussians) {
  SceneOutlook scene = SceneOutlookOf(24, 640, 480);
  scene.gaussians = 0;
  EXPECT_FALSE(ExportNeed({}, 1, scene).known());
  EXPECT_FALSE(ExportNeed({}, 1, {}).known());
}

}  // namespace
}  // namespace freegs::stages
