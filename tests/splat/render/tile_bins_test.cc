// SPDX-License-Identifier: BSD-3-Clause

#include "splat/render/tile_bins.h"

#include <cmath>
#include <map>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "splat/projection/projection.h"
#include "tests/splat/test_scene.h"

namespace freegs::splat {
namespace {

// Tiles with a pixel centre where the splat's alpha reaches 1/255 (grown by
// `slack` in the exponent).
std::set<int> TouchedTiles(
    const Splat& splat, int width, int height, int tiles_x, double slack) {
  std::set<int> tiles;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double dx = x + 0.5 - splat.mean_x, dy = y + 0.5 - splat.mean_y;
      const double q = splat.conic_xx * dx * dx +
                       2.0 * splat.conic_xy * dx * dy +
                       splat.conic_yy * dy * dy;
      const double log2_alpha = splat.log2_opacity - 0.5 * q / std::log(2.0);
      if (log2_alpha + slack >= std::log2(1.0 / 255)) {
        tiles.insert(y / kTileSize * tiles_x + x / kTileSize);
      }
    }
  }
  return tiles;
}

TEST(TileBins, HoldsEveryTouchedTileAndFewMore) {
  const GaussianModel model = RandomSceneModel(400, 0, 12);
  const Pinhole camera = TestCamera(150, 110);
  ThreadPool pool(3);
  Projector projector;
  Projection projection;
  projector.Project(
      model, camera, TestPose(), RenderOptions(), pool, &projection);
  TileBins bins;
  ASSERT_TRUE(
      BinSplats(projection, camera.width, camera.height, pool, &bins).ok());
  ASSERT_EQ(bins.tiles_x, 10);
  ASSERT_EQ(bins.tiles_y, 7);

  std::map<uint32_t, size_t> rank;  // By depth, of each visible Gaussian.
  for (const uint32_t place : projection.by_depth) {
    const size_t nearer = rank.size();
    EXPECT_TRUE(rank.emplace(projection.visible[place], nearer).second);
  }
  std::map<uint32_t, std::set<int>> got;
  for (int t = 0; t < bins.tiles_x * bins.tiles_y; ++t) {
    for (int64_t e = bins.tile_begin[t]; e < bins.tile_begin[t + 1]; ++e) {
      const uint32_t i = bins.entries[e];
      ASSERT_TRUE(rank.contains(i));
      if (e > bins.tile_begin[t]) {
        EXPECT_LT(rank[bins.entries[e - 1]], rank[i]);
      }
      EXPECT_TRUE(got[i].insert(t).second);
    }
  }
  std::set<uint32_t> listed;
  size_t needed = 0;
  for (size_t place = 0; place < projection.size(); ++place) {
    const uint32_t i = projection.visible[place];
    for (const uint32_t e : bins.EntriesOf(place)) {
      EXPECT_EQ(bins.entries[e], i);
      EXPECT_TRUE(listed.insert(e).second);
    }
    const std::set<int> want = TouchedTiles(
        projection.splats[i], camera.width, camera.height, bins.tiles_x, -1e-4);
    needed += want.size();
    for (const int t : want) EXPECT_TRUE(got[i].contains(t)) << i << ' ' << t;
  }
  EXPECT_EQ(listed.size(), bins.num_pairs());
  // The test is exact on tile rows up to the pixel grid.
  EXPECT_LT(static_cast<double>(bins.num_pairs()), 1.12 * needed);
}

// A row of tiles that 33 splats cover from end to end.
TEST(TileBins, RefusesMorePairsThanItCanCount) {
  constexpr int kWidth = 1 << 30;
  Projection projection;
  projection.splats.resize(1);
  projection.splats[0].x_end = kWidth;
  projection.splats[0].y_end = kTileSize;
  projection.visible.assign(33, 0);
  ThreadPool pool(2);
  TileBins bins;
  const Status status = BinSplats(projection, kWidth, kTileSize, pool, &bins);
  EXPECT_EQ(status.code(), StatusCode::kUnusableResult);
  EXPECT_NE(status.message().find("has 2214592512 pairs"), std::string::npos);
}

TEST(TileBins, DepthOrder) {
  const GaussianModel model = RandomSceneModel(500, 0, 13);
  ThreadPool pool(2);
  Projector projector;
  Projection projection;
  projector.Project(model,
                    TestCamera(64, 64),
                    TestPose(),
                    RenderOptions(),
                    pool,
                    &projection);
  ASSERT_GT(projection.size(), 100u);
  for (size_t k = 1; k < projection.size(); ++k) {
    EXPECT_LE(projection.SplatAt(projection.by_depth[k - 1]).depth,
              projection.SplatAt(projection.by_depth[k]).depth);
  }
}

}  // namespace
}  // namespace freegs::splat
