// SPDX-License-Identifier: BSD-3-Clause

#include "core/kd_tree_simd.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/for_each_target.h"

namespace freegs {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kMax = std::numeric_limits<float>::max();

struct Block {
  std::vector<float> points;  // dim x 16.
  std::vector<float> boxes;   // dim x 2 x 16.
  std::vector<float> query;
  std::vector<double> point2;  // Exact.
  std::vector<double> box2;
};

// The last entry is missing.
Block MakeBlock(int dim, float scale, uint64_t seed) {
  Block block;
  block.points.resize(dim * kKdBlockSize);
  block.boxes.resize(2 * dim * kKdBlockSize);
  block.point2.assign(kKdBlockSize, 0);
  block.box2.assign(kKdBlockSize, 0);
  for (int k = 0; k < dim; ++k) {
    const auto query = static_cast<float>(scale * RandomUniform(seed, 0, k));
    block.query.push_back(query);
    for (int j = 0; j < kKdBlockSize; ++j) {
      const uint64_t counter = static_cast<uint64_t>(k) * kKdBlockSize + j;
      const bool missing = j == kKdBlockSize - 1;
      const auto a =
          static_cast<float>(scale * RandomUniform(seed, 1, counter));
      const auto b =
          static_cast<float>(scale * RandomUniform(seed, 2, counter));
      const float low = missing ? kInfinity : std::min(a, b);
      const float high = missing ? -kInfinity : std::max(a, b);
      block.points[k * kKdBlockSize + j] = missing ? kInfinity : a;
      block.boxes[k * 2 * kKdBlockSize + j] = low;
      block.boxes[k * 2 * kKdBlockSize + kKdBlockSize + j] = high;
      const double d = static_cast<double>(a) - query;
      const double outside = std::max({0.0,
                                       static_cast<double>(low) - query,
                                       static_cast<double>(query) - high});
      block.point2[j] += missing ? kInfinity : d * d;
      block.box2[j] += outside * outside;
    }
  }
  return block;
}

void ExpectBounds(const float* bounds,
                  const std::vector<double>& exact,
                  int dim) {
  for (int j = 0; j < kKdBlockSize; ++j) {
    EXPECT_LE(bounds[j], exact[j]);
    EXPECT_GE(bounds[j], exact[j] * KdTieFactor(dim) - 2 * kKdSlack);
  }
}

TEST(KdTreeSimdTest, BoundsLieJustBelowTheDistances) {
  ForEachTarget([] {
    for (const int dim : {1, 2, 3, 7, 12, 100}) {
      // Squares from below the smallest float to near the largest.
      for (const float scale : {1e-24f, 1e-19f, 1.0f, 1e15f}) {
        const Block block = MakeBlock(dim, scale, dim);
        float bounds[kKdBlockSize];
        const uint32_t points = KdPointBounds(
            block.points.data(), dim, block.query.data(), kMax, bounds);
        EXPECT_EQ(points, 0x7fffu);
        ExpectBounds(bounds, block.point2, dim);
        const uint32_t boxes = KdBoxBounds(
            block.boxes.data(), dim, block.query.data(), kMax, bounds);
        EXPECT_EQ(boxes, 0x7fffu);
        ExpectBounds(bounds, block.box2, dim);
      }
    }
  });
}

TEST(KdTreeSimdTest, LimitsAndFilters) {
  ForEachTarget([] {
    const Block block = MakeBlock(5, 1, 3);
    std::vector<uint32_t> components(kKdBlockSize);
    std::vector<float> floors(kKdBlockSize, 0.0f);
    for (int j = 0; j < kKdBlockSize; ++j) components[j] = j % 3;
    floors[4] = 9;
    float bounds[kKdBlockSize];
    const float limit = 0.7f;
    for (const bool boxes : {false, true}) {
      const KdBlockFilter filter{
          .components = components.data(), .own = 2, .floors = floors.data()};
      const float* query = block.query.data();
      const KdBlockBounds result =
          boxes
              ? KdBoxBounds(block.boxes.data(), 5, query, filter, limit, bounds)
              : KdPointBounds(
                    block.points.data(), 5, query, filter, limit, bounds);
      float beyond = kInfinity;
      for (int j = 0; j < kKdBlockSize; ++j) {
        const double exact = boxes ? block.box2[j] : block.point2[j];
        const double weight = j == 4 ? 9 : exact;
        const bool within = j % 3 != 2 && weight <= limit;
        EXPECT_EQ((result.within >> j) & 1, within ? 1u : 0u) << j;
        if (j % 3 == 2) {
          EXPECT_EQ(bounds[j], kInfinity);
        } else if (!within) {
          beyond = std::min(beyond, bounds[j]);
        }
      }
      EXPECT_EQ(result.least_beyond, beyond);
    }
  });
}

TEST(KdTreeSimdTest, FloorsAreNotAbove) {
  for (const double x : {0.0, 1e-300, 1e-44, 1e-38, 0.1, 1.0 / 3, 7e20}) {
    EXPECT_LE(KdFloor(x), x);
    EXPECT_GE(KdFloor(x), x * (1 - 1e-6) - 2 * kKdSlack);
  }
}

}  // namespace
}  // namespace freegs
