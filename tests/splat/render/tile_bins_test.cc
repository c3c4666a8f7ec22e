// SPDX-License-Identifier: BSD-3-Clause

#include "splat/render/tile_bins.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "splat/projection/ewa_projection-inl.h"
#include "splat/projection/projection.h"
#include "tests/splat/test_scene.h"

namespace freegs::splat {
namespace {

// Tiles with a pixel centre where the alpha of a splat reaches 1/255 (grown by
// `slack` in the exponent).
std::set<int> TouchedTiles(const double mean[2],
                           double conic_xx,
                           double shear,
                           double precision_y,
                           double log2_opacity,
                           const Pinhole& camera,
                           int tiles_x,
                           double slack) {
  std::set<int> tiles;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double dx = x + 0.5 - mean[0], dy = y + 0.5 - mean[1];
      const double sheared = dx + shear * dy;
      const double q = conic_xx * sheared * sheared + precision_y * dy * dy;
      const double log2_alpha = log2_opacity - 0.5 * q / std::log(2.0);
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
    const Splat& splat = projection.splats[i];
    const double mean[2] = {splat.mean_x, splat.mean_y};
    const std::set<int> want = TouchedTiles(mean,
                                            splat.conic_xx,
                                            splat.shear,
                                            splat.precision_y,
                                            splat.log2_opacity,
                                            camera,
                                            bins.tiles_x,
                                            -1e-4);
    needed += want.size();
    for (const int t : want) EXPECT_TRUE(got[i].contains(t)) << i << ' ' << t;
  }
  EXPECT_EQ(listed.size(), bins.num_pairs());
  // The test is exact on tile rows up to the pixel grid.
  EXPECT_LT(static_cast<double>(bins.num_pairs()), 1.12 * needed);
}

// The splats of Gaussians right in front of the camera are far longer than the
// picture. Their tiles follow from the exact projection in doubles.
TEST(TileBins, HoldsEveryTileOfLongAndThinSplats) {
  GaussianModel model = RandomSceneModel(300, 0, 14);
  for (size_t i = 0; i < model.size(); ++i) {
    model.means[3 * i] *= 0.05f;
    model.means[3 * i + 1] *= 0.05f;
    model.means[3 * i + 2] = 0.3f;
    // Deviations of 500 to 50000 pixels along, and of a pixel across.
    model.log_scales[3 * i] = 0.2f + 0.015f * static_cast<float>(i);
    model.log_scales[3 * i + 1] = std::log(2e-3f);
    model.log_scales[3 * i + 2] = std::log(1e-3f);
    model.opacity_logits[i] = 2;
  }
  const Pinhole camera = TestCamera(150, 110);
  ThreadPool pool(2);
  Projector projector;
  Projection projection;
  projector.Project(
      model, camera, Rigid3d(), RenderOptions(), pool, &projection);
  ASSERT_EQ(projection.size(), model.size());
  TileBins bins;
  ASSERT_TRUE(
      BinSplats(projection, camera.width, camera.height, pool, &bins).ok());
  std::map<uint32_t, std::set<int>> got;
  for (int t = 0; t < bins.tiles_x * bins.tiles_y; ++t) {
    for (int64_t e = bins.tile_begin[t]; e < bins.tile_begin[t + 1]; ++e) {
      got[bins.entries[e]].insert(t);
    }
  }
  const auto exact_camera =
      MakeProjectionCamera<double>(camera, Rigid3d(), RenderOptions());
  size_t needed = 0;
  for (size_t i = 0; i < model.size(); ++i) {
    double input[10];
    std::copy_n(&model.means[3 * i], 3, input);
    std::copy_n(&model.log_scales[3 * i], 3, input + 3);
    std::copy_n(&model.rotations[4 * i], 4, input + 6);
    ProjectedGaussian<double> exact;
    ProjectionTerms<double> terms;
    ASSERT_TRUE(HWY_NAMESPACE::ProjectGaussian(
        exact_camera, input, input + 3, input + 6, &exact, &terms));
    const std::set<int> want = TouchedTiles(exact.mean,
                                            exact.conic_xx,
                                            exact.shear,
                                            exact.precision_y,
                                            projection.splats[i].log2_opacity,
                                            camera,
                                            bins.tiles_x,
                                            -0.01);
    needed += want.size();
    for (const int t : want) EXPECT_TRUE(got[i].contains(t)) << i << ' ' << t;
  }
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
