// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/hdbscan/mutual_reachability_mst.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::semantics {
namespace {

// Points in blobs; with a grid > 0 snapped to it, which makes ties and
// duplicates.
std::vector<float> MakePoints(int count, int dim, uint64_t seed, double grid) {
  std::vector<float> points(static_cast<size_t>(count) * dim);
  for (int i = 0; i < count; ++i) {
    const uint64_t blob = RandomIndex(seed, 0, i, 4);
    for (int k = 0; k < dim; ++k) {
      const uint64_t counter = static_cast<uint64_t>(i) * dim + k;
      double x = RandomUniform(seed, 1, blob * dim + k) +
                 0.1 * RandomNormal(seed, 2, counter);
      if (grid > 0) x = std::round(x / grid) * grid;
      points[counter] = static_cast<float>(x);
    }
  }
  return points;
}

double Distance2(const std::vector<float>& points, int dim, int i, int j) {
  double sum = 0;
  for (int k = 0; k < dim; ++k) {
    const double d =
        static_cast<double>(points[i * dim + k]) - points[j * dim + k];
    sum += d * d;
  }
  return sum;
}

std::vector<double> BruteForceCore2(const std::vector<float>& points,
                                    int dim,
                                    int min_samples) {
  const int count = static_cast<int>(points.size()) / dim;
  std::vector<double> core2(count);
  for (int i = 0; i < count; ++i) {
    std::vector<double> distances;
    for (int j = 0; j < count; ++j) {
      if (j != i) distances.push_back(Distance2(points, dim, i, j));
    }
    std::sort(distances.begin(), distances.end());
    core2[i] = distances[std::min(min_samples, count - 1) - 1];
  }
  return core2;
}

// Prim's algorithm on the dense graph, under the same total order.
std::vector<MstEdge> BruteForceMst(const std::vector<float>& points,
                                   int dim,
                                   const std::vector<double>& core2) {
  const uint32_t count = static_cast<uint32_t>(core2.size());
  std::vector<MstEdge> best(
      count, {std::numeric_limits<double>::infinity(), ~0u, ~0u});
  std::vector<bool> done(count, false);
  std::vector<MstEdge> mst;
  uint32_t current = 0;
  for (uint32_t step = 1; step < count; ++step) {
    done[current] = true;
    uint32_t next = current;
    for (uint32_t j = 0; j < count; ++j) {
      if (done[j]) continue;
      const double weight2 = std::max(
          {core2[current], core2[j], Distance2(points, dim, current, j)});
      best[j] = std::min(best[j],
                         {weight2, std::min(current, j), std::max(current, j)});
      if (next == current || best[j] < best[next]) next = j;
    }
    mst.push_back(best[next]);
    current = next;
  }
  std::sort(mst.begin(), mst.end());
  return mst;
}

struct Case {
  int count;
  int dim;
  int min_samples;
  double grid;
};

class MstTest : public testing::TestWithParam<Case> {};

TEST_P(MstTest, EqualsPrimOnTheDenseGraph) {
  const auto [count, dim, min_samples, grid] = GetParam();
  for (uint64_t seed = 0; seed < 3; ++seed) {
    const std::vector<float> points = MakePoints(count, dim, seed, grid);
    const std::vector<double> expected_core2 =
        BruteForceCore2(points, dim, min_samples);
    const std::vector<MstEdge> expected =
        BruteForceMst(points, dim, expected_core2);
    const auto tree = KdTree::Build(points, dim);
    ASSERT_TRUE(tree.ok());
    for (const int threads : {1, 3}) {
      ThreadPool pool(threads);
      const auto cores =
          ComputeCoreDistances(*tree, min_samples, pool, nullptr);
      ASSERT_TRUE(cores.ok());
      for (int p = 0; p < count; ++p) {
        ASSERT_EQ(cores->core2[p], expected_core2[tree->Row(p)]);
      }
      const auto mst = MutualReachabilityMst(*tree, *cores, pool, nullptr);
      ASSERT_TRUE(mst.ok());
      EXPECT_EQ(*mst, expected) << "seed " << seed << " threads " << threads;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes,
                         MstTest,
                         testing::Values(Case{2, 3, 5, 0},
                                         Case{17, 2, 4, 0},
                                         Case{300, 1, 3, 0},
                                         Case{700, 2, 5, 0},
                                         Case{900, 3, 1, 0},
                                         Case{900, 6, 20, 0},
                                         Case{500, 12, 10, 0},
                                         Case{60, 3, 100, 0},
                                         Case{900, 3, 5, 0.05},
                                         Case{900, 2, 8, 0.1},
                                         Case{600, 12, 4, 0.25}));

TEST(MstTest, ManyIdenticalPointsStayFast) {
  // Quadratic work on 200000 duplicates would run into the test's time limit.
  std::vector<float> points(200000 * 3, 0.5f);
  for (int i = 0; i < 100; ++i) points[i * 3] = static_cast<float>(i);
  const auto tree = KdTree::Build(points, 3);
  ASSERT_TRUE(tree.ok());
  ThreadPool pool(2);
  const auto cores = ComputeCoreDistances(*tree, 5, pool, nullptr);
  ASSERT_TRUE(cores.ok());
  const auto mst = MutualReachabilityMst(*tree, *cores, pool, nullptr);
  ASSERT_TRUE(mst.ok());
  EXPECT_EQ(mst->size(), 199999u);
  EXPECT_EQ((*mst)[199999 - 200].weight2, 0);
}

TEST(MstTest, NoPointsAndOnePoint) {
  ThreadPool pool(1);
  for (const int count : {0, 1}) {
    const auto tree = KdTree::Build(std::vector<float>(count * 3, 1.0f), 3);
    ASSERT_TRUE(tree.ok());
    const auto cores = ComputeCoreDistances(*tree, 5, pool, nullptr);
    ASSERT_TRUE(cores.ok());
    const auto mst = MutualReachabilityMst(*tree, *cores, pool, nullptr);
    ASSERT_TRUE(mst.ok());
    EXPECT_TRUE(mst->empty());
  }
}

TEST(MstTest, StopsWhenCancelled) {
  const std::vector<float> points = MakePoints(500, 3, 1, 0);
  const auto tree = KdTree::Build(points, 3);
  ASSERT_TRUE(tree.ok());
  ThreadPool pool(1);
  const auto cores = ComputeCoreDistances(*tree, 5, pool, nullptr);
  ASSERT_TRUE(cores.ok());
  CancellationToken cancellation;
  cancellation.Cancel();
  EXPECT_EQ(
      MutualReachabilityMst(*tree, *cores, pool, &cancellation).status().code(),
      StatusCode::kInterrupted);
}

}  // namespace
}  // namespace freegs::semantics
