// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/scene_size.h"

#include <gtest/gtest.h>

#include "splat/scene/ply_io.h"
#include "tests/splat/test_scene.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

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
