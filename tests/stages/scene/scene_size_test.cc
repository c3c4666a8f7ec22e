// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/scene_size.h"

#include <vector>

#include <gtest/gtest.h>

#include "splat/scene/ply_io.h"
#include "tests/splat/test_scene.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

TEST(SceneSizeTest, CountsPixelsAtTheLimitedSize) {
  std::vector<View> views(3);
  views[0].camera = splat::TestCamera(80, 60);
  views[1].camera = splat::TestCamera(40, 20);
  views[2].camera = splat::TestCamera(30, 60);
  EXPECT_EQ(CountPixels(views, 0).total, 4800 + 800 + 1800);
  EXPECT_EQ(CountPixels(views, 0).largest, 4800);
  EXPECT_EQ(CountPixels(views, 40).total, 1200 + 800 + 800);
  EXPECT_EQ(CountPixels(views, 40).largest, 1200);
  EXPECT_EQ(CountPixels({}, 40).total, 0);
}

TEST(SceneSizeTest, CountsTheGaussiansOfAFile) {
  const TemporaryFolder folder;
  ASSERT_TRUE(
      splat::WritePly(folder / "a.ply", splat::RandomSceneModel(80, 3, 1))
          .ok());
  EXPECT_EQ(CountGaussians(folder / "a.ply"), 80);
  folder.Write("b.ply", "ply");
  EXPECT_FALSE(CountGaussians(folder / "b.ply").has_value());
  EXPECT_FALSE(CountGaussians(folder / "missing.ply").has_value());
}

}  // namespace
}  // namespace freegs::stages
