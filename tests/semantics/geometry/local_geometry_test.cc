// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/geometry/local_geometry.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::semantics {
namespace {

TEST(LocalGeometryTest, NormalsOfATiltedPlane) {
  // z = x / 2.
  std::vector<float> points;
  for (int i = 0; i < 500; ++i) {
    const auto x = static_cast<float>(RandomUniform(1, 0, i));
    const auto y = static_cast<float>(RandomUniform(1, 1, i));
    points.insert(points.end(), {x, y, x / 2});
  }
  ThreadPool pool(2);
  const auto tree = KdTree::Build(points, 3);
  ASSERT_TRUE(tree.ok());
  const std::vector<float> normals = ComputeNormals(*tree, 12, pool);
  ASSERT_EQ(normals.size(), points.size());
  const double length = std::sqrt(1.25);
  for (size_t i = 0; i < normals.size(); i += 3) {
    const double sign = normals[i + 2] > 0 ? 1 : -1;
    EXPECT_NEAR(sign * normals[i], -0.5 / length, 1e-3);
    EXPECT_NEAR(normals[i + 1], 0, 1e-3);
    EXPECT_NEAR(sign * normals[i + 2], 1 / length, 1e-3);
  }
}

TEST(LocalGeometryTest, NormalsOfDegenerateNeighbourhoodsAreUnit) {
  const std::vector<float> points(30, 1.0f);
  ThreadPool pool(1);
  const auto tree = KdTree::Build(points, 3);
  const std::vector<float> normals = ComputeNormals(*tree, 5, pool);
  for (size_t i = 0; i < normals.size(); i += 3) {
    EXPECT_NEAR(
        std::hypot(normals[i], normals[i + 1], normals[i + 2]), 1, 1e-5);
  }
}

}  // namespace
}  // namespace freegs::semantics
