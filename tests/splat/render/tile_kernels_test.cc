// SPDX-License-Identifier: BSD-3-Clause

#include "splat/render/tile_kernels.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/for_each_target.h"

namespace freegs::splat {
namespace {

double Between(RandomStream& random, double low, double high) {
  return low + (high - low) * random.Uniform();
}

// A splat somewhere around a tile at (32, 16): round or as thin as a needle,
// smaller than a pixel or larger than the tile.
Splat RandomSplat(RandomStream& random) {
  const double length = std::exp(Between(random, -0.7, 4.0));
  const double width = std::max(0.5, length * std::exp(-Between(random, 0, 4)));
  const double angle = Between(random, 0, std::numbers::pi);
  const double along = 1 / (length * length), across = 1 / (width * width);
  const double c = std::cos(angle), s = std::sin(angle);
  Splat splat = {};
  splat.mean_x = static_cast<float>(32 + Between(random, -30, 46));
  splat.mean_y = static_cast<float>(16 + Between(random, -30, 46));
  const double xx = along * c * c + across * s * s;
  splat.conic_xx = static_cast<float>(xx);
  splat.shear = static_cast<float>((along - across) * c * s / xx);
  splat.precision_y = static_cast<float>(along * across / xx);
  splat.log2_opacity = static_cast<float>(Between(random, -7.9, 0));
  return splat;
}

double Log2Alpha(const Splat& splat, double x, double y) {
  const double dx = x + 0.5 - splat.mean_x, dy = y + 0.5 - splat.mean_y;
  const double sheared = dx + splat.shear * dy;
  return splat.log2_opacity -
         0.5 * std::numbers::log2e *
             (splat.conic_xx * sheared * sheared + splat.precision_y * dy * dy);
}

// The blocks of the task's tile with a pixel at which log2(alpha) is at least
// `least`, looked for at `steps` places a pixel in both directions.
TileBlocks BlocksWith(const TileTask& task,
                      const Splat& splat,
                      double least,
                      int steps) {
  TileBlocks blocks = 0;
  for (int b = 0; b < kNumBlocks; ++b) {
    for (int j = 0; j <= 3 * steps; ++j) {
      for (int i = 0; i <= 3 * steps; ++i) {
        const double x = task.x0 + b % 4 * 4 + static_cast<double>(i) / steps;
        const double y = task.y0 + b / 4 * 4 + static_cast<double>(j) / steps;
        if (Log2Alpha(splat, x, y) >= least) {
          blocks |= 1u << b;
        }
      }
    }
  }
  return blocks;
}

TEST(TileKernels, BlocksOfASplatAreThoseThatItReaches) {
  ForEachTarget([] {
    RandomStream random(3, 1);
    int touched_splats = 0;
    for (int k = 0; k < 2000; ++k) {
      const Splat splat = RandomSplat(random);
      const uint32_t entry = 0;
      TileTask task;
      task.splats = &splat;
      task.entries = &entry;
      task.count = 1;
      task.x0 = 32;
      task.y0 = 16;
      task.width = task.height = kTileSize;
      TilePixels pixels;
      TileBlocks touched = 0;
      ASSERT_EQ(BlendTile(task, &pixels, nullptr, nullptr, &touched), 1);
      const double least = -std::log2(255.0);
      const TileBlocks needed = BlocksWith(task, splat, least, 1);
      EXPECT_EQ(needed & ~touched, 0u) << "splat " << k;
      // Nothing lies outside what alpha reaches between the pixels' centres,
      // but for the room that is left for rounding.
      const TileBlocks allowed = BlocksWith(task, splat, least - 0.1, 8);
      EXPECT_EQ(touched & ~allowed, 0u) << "splat " << k;
      touched_splats += touched != 0;
    }
    EXPECT_GT(touched_splats, 400);
  });
}

TEST(TileKernels, BlocksOutsideThePictureAreNotTouched) {
  Splat splat = {};
  splat.mean_x = splat.mean_y = 8;
  splat.conic_xx = splat.precision_y = 0.01f;
  const uint32_t entry = 0;
  TileTask task;
  task.splats = &splat;
  task.entries = &entry;
  task.count = 1;
  task.width = 5;  // Two blocks wide.
  task.height = 4;
  TilePixels pixels;
  TileBlocks touched = 0;
  ASSERT_EQ(BlendTile(task, &pixels, nullptr, nullptr, &touched), 1);
  EXPECT_EQ(touched, 0b11u);
}

}  // namespace
}  // namespace freegs::splat
