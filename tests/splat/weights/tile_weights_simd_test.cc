// SPDX-License-Identifier: BSD-3-Clause

#include "splat/weights/tile_weights_simd.h"

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "tests/for_each_target.h"

namespace freegs::splat {
namespace {

// It is 100 000 pixels long and a pixel wide, and its edge crosses a block of
// the tile where a fused multiplication and one that is not differ by more than
// what TouchedBlocks allows for.
TEST(TileWeights, OfALongThinSplatAreTheSameForAnyInstructionSet) {
  Splat splat = {};
  splat.mean_x = 69738.7422f;
  splat.mean_y = -50281.1719f;
  splat.conic_xx = 1.03416979f;
  splat.shear = 1.38679373f;
  splat.precision_y = 2.2238425e-10f;
  splat.log2_opacity = std::log2(0.9f);
  const uint32_t entry = 0;
  const TileTask task = {.splats = &splat,
                         .entries = &entry,
                         .count = 1,
                         .width = kTileSize,
                         .height = kTileSize};
  std::vector<std::vector<float>> found;
  ForEachTarget([&] {
    alignas(64) float transmittance[kTilePixels];
    const auto list = std::make_unique<TileWeightList>();
    ListTileWeights(task, 0, transmittance, list.get());
    found.emplace_back(list->weight, list->weight + list->count);
    EXPECT_FALSE(found.back().empty());
    EXPECT_EQ(found.back(), found.front());
  });
}

}  // namespace
}  // namespace freegs::splat
