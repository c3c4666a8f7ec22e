// SPDX-License-Identifier: BSD-3-Clause

#include "core/kd_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs {
namespace {

TEST(KdTreeTest, NearestEqualsBruteForceIncludingTies) {
  for (const int dim : {1, 2, 3, 6, 12}) {
    for (const bool grid : {false, true}) {
      const int count = 400;
      std::vector<float> points(count * dim);
      for (size_t i = 0; i < points.size(); ++i) {
        const double x = RandomUniform(dim, grid, i);
        points[i] = static_cast<float>(grid ? std::floor(x * 4) : x);
      }
      const auto tree = KdTree::Build(points, dim);
      ASSERT_TRUE(tree.ok());
      std::vector<Neighbor> found;
      for (int i = 0; i < count; i += 7) {
        std::vector<Neighbor> expected;
        for (int j = 0; j < count; ++j) {
          if (j == i) continue;
          expected.push_back(
              {tree->Distance2(&points[i * dim], &points[j * dim]),
               static_cast<uint32_t>(j)});
        }
        std::sort(expected.begin(), expected.end());
        tree->Nearest(&points[i * dim], 9, i, &found);
        ASSERT_EQ(found.size(), 9u);
        for (int k = 0; k < 9; ++k) {
          EXPECT_EQ(found[k].index, expected[k].index);
          EXPECT_EQ(found[k].distance2, expected[k].distance2);
        }
      }
    }
  }
}

TEST(KdTreeTest, FewerPointsThanAsked) {
  const std::vector<float> points = {0, 0, 1, 0, 5, 0};
  const auto tree = KdTree::Build(points, 2);
  ASSERT_TRUE(tree.ok());
  std::vector<Neighbor> found;
  tree->Nearest(points.data(), 10, KdTree::kNoRow, &found);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[2].index, 2u);
  tree->Nearest(points.data(), 0, KdTree::kNoRow, &found);
  EXPECT_TRUE(found.empty());
}

TEST(KdTreeTest, FarAndTinyCoordinatesKeepTheirOrder) {
  // Squares of the tiny ones underflow a float.
  const std::vector<float> points = {0, 1e-30f, 3e-30f, 1e14f, -1e14f, 2e14f};
  const auto tree = KdTree::Build(points, 1);
  ASSERT_TRUE(tree.ok());
  std::vector<Neighbor> found;
  tree->Nearest(points.data(), 5, 0, &found);
  ASSERT_EQ(found.size(), 5u);
  EXPECT_EQ(found[0].index, 1u);
  EXPECT_EQ(found[1].index, 2u);
  EXPECT_EQ(found[4].index, 5u);
}

TEST(KdTreeTest, RefusesWhatIsNotAPoint) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  for (const float bad : {nan, inf, -inf, 1e16f}) {
    EXPECT_EQ(KdTree::Build(std::vector<float>{0, 1, bad}, 3).status().code(),
              StatusCode::kInvalidArgument);
  }
  EXPECT_FALSE(KdTree::Build(std::vector<float>{0, 1, 2}, 2).ok());
  EXPECT_FALSE(KdTree::Build(std::vector<float>{0, 1, 2}, 0).ok());
}

}  // namespace
}  // namespace freegs
