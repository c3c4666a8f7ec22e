// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/forecast/stage_need.h"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/forecast/scene_outlook.h"

namespace freegs::pipeline {
namespace {

using ::testing::ElementsAre;

TEST(StageNeedTest, ThreadsDivideAllButTheSerialShare) {
  EXPECT_EQ(OnThreads(10, 0.2, 1), 10);
  EXPECT_EQ(OnThreads(10, 0.2, 4), 4);
  EXPECT_EQ(OnThreads(10, 1, 4), 10);
}

TEST(StageNeedTest, TheTotalIsOfTheNeededStages) {
  const std::vector<StageForecast> stages = {
      {.stage = "a", .need = {.memory_bytes = 3000, .seconds = 20}},
      {.stage = "b", .need = {}},
      {.stage = "c",
       .needed = false,
       .need = {.memory_bytes = 9000, .disk_bytes = 9, .seconds = 9}},
      {.stage = "d",
       .need = {.memory_bytes = 2000, .disk_bytes = 50, .seconds = 60}}};
  const RunNeed total = Total(stages);
  EXPECT_EQ(total.sum.memory_bytes, 3000);
  EXPECT_EQ(total.sum.disk_bytes, 50);
  EXPECT_EQ(total.sum.seconds, 80);
  EXPECT_THAT(total.unknown, ElementsAre("b"));
  EXPECT_EQ(RunNeedText(total),
            "expected to take about 1 min 20 s, 3.0 kB of memory and 50 B of "
            "disk space; nothing is known of b");
  EXPECT_EQ(RunNeedText({.sum = {}, .unknown = {"b", "c"}}),
            "nothing is known of b, c");
  EXPECT_EQ(RunNeedText({}), "");
}

TEST(SceneOutlookTest, CountsPixelsAtTheLimitedSize) {
  SceneOutlook scene;
  scene.train.resize(2);
  scene.holdout.resize(1);
  scene.train[0].camera = {.width = 80, .height = 60};
  scene.train[1].camera = {.width = 40, .height = 20};
  scene.holdout[0].camera = {.width = 30, .height = 60};
  EXPECT_EQ(scene.photos(), 3);
  EXPECT_EQ(CountPixels(scene, 0).total, 4800 + 800 + 1800);
  EXPECT_EQ(CountPixels(scene, 0).largest, 4800);
  EXPECT_EQ(CountPixels(scene, 40).total, 1200 + 800 + 800);
  EXPECT_EQ(CountPixels(scene, 40).largest, 1200);
  EXPECT_EQ(CountPixels(SceneOutlook(), 40).total, 0);
}

}  // namespace
}  // namespace freegs::pipeline
