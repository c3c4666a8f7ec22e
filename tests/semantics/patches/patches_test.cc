// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/patches.h"

#include <cmath>
#include <limits>
#include <map>

#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/semantics/synthetic_gaussians.h"

namespace freegs::semantics {
namespace {

// A square of side 1 at z = 0, half of it red and half of it blue.
SurfacePoints Square(size_t count) {
  SurfacePoints points;
  RandomStream random(1, 2);
  for (size_t i = 0; i < count; ++i) {
    const auto x = static_cast<float>(random.Uniform());
    const auto y = static_cast<float>(random.Uniform());
    const float red = x < 0.43f ? 1 : 0;
    points.positions.insert(points.positions.end(), {x, y, 0});
    points.normals.insert(points.normals.end(),
                          {0, 0, i % 2 == 0 ? 1.0f : -1.0f});
    points.colors.insert(points.colors.end(), {red, 0, 1 - red});
  }
  return points;
}

TEST(PatchesTest, PatchesAreSmallAndOfOneColor) {
  const SurfacePoints points = Square(3000);
  ThreadPool pool(2);
  const auto patches =
      MakePatches(points, std::vector<float>(3000, 0.1f), 0, pool);
  ASSERT_TRUE(patches.ok());
  EXPECT_GT(patches->count, 30);
  EXPECT_LT(patches->count, 200);
  std::map<int32_t, std::pair<int, int>> red_and_blue;
  for (size_t i = 0; i < 3000; ++i) {
    auto& counts = red_and_blue[patches->patch_of_point[i]];
    ++(points.colors[i * 3] > 0 ? counts.first : counts.second);
  }
  for (const auto& [patch, counts] : red_and_blue) {
    EXPECT_TRUE(counts.first == 0 || counts.second == 0) << patch;
  }
}

TEST(PatchesTest, SamePatchesForAnyNumberOfThreads) {
  const SurfacePoints points = Square(1000);
  const std::vector<float> sizes(1000, 0.1f);
  ThreadPool one(1);
  ThreadPool three(3);
  const auto a = MakePatches(points, sizes, 0, one);
  const auto b = MakePatches(points, sizes, 0, three);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a->patch_of_point, b->patch_of_point);
}

TEST(PatchesTest, RefusesSizesThatAreNotPositive) {
  const SurfacePoints points = Square(2);
  ThreadPool pool(1);
  for (const float size : {0.0f,
                           -1.0f,
                           std::numeric_limits<float>::infinity(),
                           std::numeric_limits<float>::quiet_NaN()}) {
    EXPECT_FALSE(
        MakePatches(points, std::vector<float>{1, size}, 0, pool).ok());
  }
  EXPECT_EQ(MakePatches({}, {}, 0, pool)->count, 0);
}

TEST(PatchesTest, LengthOfPixelsGrowsWithDistance) {
  const View view = LookAtOrigin(0);
  const Eigen::Vector3d camera = CameraCentre(view.cam_from_world);
  const Eigen::Vector3f nearer = (0.5 * camera).cast<float>();
  const std::vector<float> positions = {
      0, 0, 0, nearer.x(), nearer.y(), nearer.z(), 1e6f, 1e6f, 0};
  ThreadPool pool(1);
  const std::vector<float> lengths =
      LengthOfPixels(positions, std::vector<View>{view}, 7, pool);
  EXPECT_NEAR(lengths[0], 7 * camera.norm() / 70, 1e-4);
  EXPECT_NEAR(lengths[1], 0.5 * lengths[0], 1e-4);
  // What no camera sees gets the median.
  EXPECT_GT(lengths[2], 0);
  EXPECT_EQ(LengthOfPixels(positions, {}, 7, pool)[0], 0);
}

}  // namespace
}  // namespace freegs::semantics
