// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/union_space.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

using testing::FloatNear;
using testing::Pointwise;

TEST(UnionSpaceTest, BlocksAreScaledWeightedAndClamped) {
  const std::vector<float> positions = {2, 2, 2, 4, 2, 0, 1e9f, 2, -1e9f};
  const std::vector<float> colors = {0, 0.5f, 1, 2, -1, 0.25f, 1, 1, 1};
  SceneExtent extent;
  extent.centre = {2, 2, 2};
  extent.radius = 2;
  const std::vector<float> points =
      BuildUnionSpace(positions,
                      colors,
                      {},
                      0,
                      extent,
                      {.position_weight = 3, .color_weight = 0.5});
  const std::vector<float> expected = {0,
                                       0,
                                       0,
                                       0,
                                       0.25f,
                                       0.5f,
                                       3,
                                       0,
                                       -3,
                                       0.5f,
                                       0,
                                       0.125f,
                                       30,
                                       0,
                                       -30,
                                       0.5f,
                                       0.5f,
                                       0.5f};
  EXPECT_THAT(points, Pointwise(FloatNear(1e-6f), expected));
}

TEST(UnionSpaceTest, SemanticBlockIsAppended) {
  std::vector<float> semantics;
  for (int i = 0; i < 400; ++i) semantics.push_back(static_cast<float>(i));
  semantics[0] = -1e9f;  // A stray value does not squash the rest.
  const std::vector<float> zeros(600, 0.0f);
  const std::vector<float> points =
      BuildUnionSpace(zeros, zeros, semantics, 2, {}, {.semantic_weight = 2});
  ASSERT_EQ(points.size(), 200u * 8);
  EXPECT_EQ(points[6], 0);
  EXPECT_NEAR(points[100 * 8 + 6], 1.0, 0.02);
  EXPECT_NEAR(points[199 * 8 + 7], 2.0, 1e-5);
}

TEST(UnionSpaceTest, RefusesBadWeights) {
  EXPECT_TRUE(UnionSpaceOptions().Check().ok());
  EXPECT_FALSE(UnionSpaceOptions{.position_weight = -1}.Check().ok());
  EXPECT_FALSE(UnionSpaceOptions{.color_weight = std::nan("")}.Check().ok());
}

}  // namespace
}  // namespace freegs::semantics
