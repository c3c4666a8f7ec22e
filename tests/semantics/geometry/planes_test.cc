// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/geometry/planes.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/kd_tree.h"
#include "core/random.h"
#include "semantics/geometry/local_geometry.h"

namespace freegs::semantics {
namespace {

struct Cloud {
  std::vector<float> points;
  uint64_t counter = 0;

  double Uniform() { return RandomUniform(3, 0, counter++); }
  void Add(double x, double y, double z) {
    for (const double value : {x, y, z}) {
      points.push_back(static_cast<float>(value));
    }
  }
  PlaneSegmentation Find(const PlaneOptions& options, int threads = 2) const {
    ThreadPool pool(threads);
    const auto tree = KdTree::Build(points, 3);
    return FindPlanes(points,
                      ComputeNormals(*tree, 16, pool),
                      /*scene_radius=*/1,
                      options,
                      /*seed=*/1,
                      pool);
  }
};

// A floor at z = 0 and a wall at x = 1, both 2 x 2, with 3 mm of noise.
Cloud MakeCorner() {
  Cloud cloud;
  for (int i = 0; i < 4000; ++i) {
    cloud.Add(2 * cloud.Uniform() - 1,
              2 * cloud.Uniform() - 1,
              0.003 * RandomNormal(3, 1, i));
  }
  for (int i = 0; i < 2500; ++i) {
    cloud.Add(1 + 0.003 * RandomNormal(3, 2, i),
              2 * cloud.Uniform() - 1,
              2 * cloud.Uniform());
  }
  return cloud;
}

// A floor of two sheets, `gap` apart.
Cloud MakeSheets(double gap) {
  Cloud cloud;
  for (int i = 0; i < 6000; ++i) {
    cloud.Add(2 * cloud.Uniform() - 1,
              2 * cloud.Uniform() - 1,
              (i % 3 == 0 ? gap : 0) + 0.001 * RandomNormal(3, 1, i));
  }
  return cloud;
}

TEST(PlanesTest, SheetsOfOneSurfaceAreOnePlane) {
  EXPECT_EQ(MakeSheets(0.04).Find({.max_distance = 0.005}).planes.size(), 1u);
  const PlaneSegmentation apart = MakeSheets(0.2).Find({.max_distance = 0.005});
  EXPECT_EQ(apart.planes.size(), 2u);
  // All points of both, but for a few.
  const PlaneSegmentation joined =
      MakeSheets(0.04).Find({.max_distance = 0.005});
  EXPECT_LT(
      std::count(joined.plane_index.begin(), joined.plane_index.end(), -1), 60);
}

TEST(PlanesTest, FindsFloorAndWall) {
  const Cloud cloud = MakeCorner();
  const PlaneSegmentation found = cloud.Find({});
  ASSERT_EQ(found.planes.size(), 2u);
  EXPECT_NEAR(std::abs(found.planes[0].normal.z()), 1, 1e-4);
  EXPECT_NEAR(found.planes[0].offset, 0, 2e-3);
  EXPECT_NEAR(std::abs(found.planes[1].normal.x()), 1, 1e-4);
  EXPECT_NEAR(std::abs(found.planes[1].offset), 1, 2e-3);
  int right = 0;
  for (int i = 0; i < 6500; ++i) {
    right += found.plane_index[i] == (i < 4000 ? 0 : 1);
  }
  EXPECT_GT(right, 6500 * 0.98);
  // The distance follows the noise.
  EXPECT_NEAR(found.planes[0].distance, 0.009, 0.003);
}

TEST(PlanesTest, SmallFacesAndSlicesThroughThingsAreNotPlanes) {
  Cloud cloud = MakeCorner();
  const size_t corner = cloud.points.size() / 3;
  // The top of a box, 0.3 x 0.3, and many balls whose tops are level with it.
  for (int i = 0; i < 600; ++i) {
    cloud.Add(0.3 * cloud.Uniform(), 0.3 * cloud.Uniform(), 0.4);
  }
  for (int ball = 0; ball < 6; ++ball) {
    for (int i = 0; i < 500; ++i) {
      const double z = 2 * cloud.Uniform() - 1;
      const double angle = 6.2831853 * cloud.Uniform();
      const double r = 0.12 * std::sqrt(1 - z * z);
      cloud.Add(-0.9 + 0.3 * ball + r * std::cos(angle),
                -0.5 + r * std::sin(angle),
                0.28 + 0.12 * z);
    }
  }
  const PlaneSegmentation found = cloud.Find({});
  EXPECT_EQ(found.planes.size(), 2u);
  for (size_t i = corner; i < found.plane_index.size(); ++i) {
    ASSERT_EQ(found.plane_index[i], -1);
  }
}

TEST(PlanesTest, SameForAnyNumberOfThreads) {
  const Cloud cloud = MakeCorner();
  EXPECT_EQ(cloud.Find({}, 1).plane_index, cloud.Find({}, 4).plane_index);
}

TEST(PlanesTest, NoneWanted) {
  EXPECT_TRUE(MakeCorner().Find({.max_planes = 0}).planes.empty());
}

TEST(PlanesTest, DegenerateCloudsHaveNone) {
  Cloud empty;
  EXPECT_TRUE(empty.Find({}).planes.empty());
  Cloud point;
  for (int i = 0; i < 100; ++i) point.Add(1, 2, 3);
  EXPECT_TRUE(point.Find({}).planes.empty());
  Cloud line;
  for (int i = 0; i < 100; ++i) line.Add(0.1 * i, 0, 0);
  EXPECT_TRUE(line.Find({}).planes.empty());
}

}  // namespace
}  // namespace freegs::semantics
