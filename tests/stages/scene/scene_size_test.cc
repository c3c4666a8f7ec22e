// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/scene_size.h"

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "splat/scene/ply_io.h"
#include "splat/scene/spz_format.h"
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
  // Larger than what is read of it.
  ASSERT_TRUE(
      splat::WriteSpz(folder / "a.SPZ", splat::RandomSceneModel(5000, 3, 1))
          .ok());
  ASSERT_GT(std::filesystem::file_size(folder / "a.SPZ"), 1u << 16);
  EXPECT_EQ(CountGaussians(folder / "a.SPZ"), 5000);
  folder.Write("b.spz", "ply");
  EXPECT_FALSE(CountGaussians(folder / "b.spz").has_value());
  folder.Write("b.ply", "ply");
  EXPECT_FALSE(CountGaussians(folder / "b.ply").has_value());
  EXPECT_FALSE(CountGaussians(folder / "missing.ply").has_value());
}

TEST(SceneSizeTest, ACountThatTheFileCannotHoldIsNone) {
  const TemporaryFolder folder;
  for (const char* count :
       {"3", "9000000000000000", "30000000000000000", "18446744073709551615"}) {
    folder.Write("a.ply",
                 std::string("ply\nformat binary_little_endian 1.0\n"
                             "element vertex ") +
                     count + "\nproperty float x\nend_header\n");
    EXPECT_EQ(CountGaussians(folder / "a.ply").has_value(), count[1] == 0)
        << count;
  }
}

}  // namespace
}  // namespace freegs::stages
