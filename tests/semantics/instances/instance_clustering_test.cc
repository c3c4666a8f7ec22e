// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/instance_clustering.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "tests/semantics/synthetic_gaussians.h"

namespace freegs::semantics {
namespace {

// Best intersection over union of any label with an object.
double BestIou(const std::vector<int32_t>& truth,
               const std::vector<int32_t>& labels,
               int32_t object) {
  std::map<int32_t, double> shared;
  std::map<int32_t, double> size;
  double count = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    count += truth[i] == object;
    if (labels[i] < 0) continue;
    size[labels[i]] += 1;
    shared[labels[i]] += truth[i] == object;
  }
  double best = 0;
  for (const auto& [label, both] : shared) {
    best = std::max(best, both / (count + size[label] - both));
  }
  return best;
}

TEST(InstanceClusteringTest, SeparatesObjectsOnATable) {
  const SyntheticGaussians scene = MakeTableScene();
  std::vector<View> views(3);
  for (int i = 0; i < 3; ++i) views[i] = LookAtOrigin(2.1 * i);
  ThreadPool pool(2);
  const auto result =
      ClusterInstances(scene.model, {}, views, {}, {}, 0, pool, nullptr);
  ASSERT_TRUE(result.ok());
  for (int object = 0; object <= 4; ++object) {
    EXPECT_GT(BestIou(scene.truth, result->labels, object), 0.9) << object;
  }
  EXPECT_EQ(result->num_instances, 5);
  EXPECT_EQ(result->scores.size(), 5u);
  // Labels by descending size: the table is first, and the only plane.
  EXPECT_EQ(result->labels[0], 0);
  EXPECT_EQ(result->is_plane, (std::vector<uint8_t>{1, 0, 0, 0, 0}));
  ASSERT_EQ(result->planes.size(), 1u);
  EXPECT_NEAR(std::abs(result->planes[0].normal.z()), 1, 1e-3);
  // Haze took no part but got labels where it is near something.
  EXPECT_EQ(result->num_clustered, scene.truth.size() - 150);
}

TEST(InstanceClusteringTest, SameLabelsForAnyNumberOfThreads) {
  const SyntheticGaussians scene = MakeTableScene();
  ThreadPool one(1);
  ThreadPool three(3);
  const auto a = ClusterInstances(scene.model, {}, {}, {}, {}, 5, one, nullptr);
  const auto b =
      ClusterInstances(scene.model, {}, {}, {}, {}, 5, three, nullptr);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a->labels, b->labels);
  EXPECT_EQ(a->scores, b->scores);
}

TEST(InstanceClusteringTest, BrokenGaussiansTakeNoPart) {
  SyntheticGaussians scene = MakeTableScene();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  scene.Add({nan, 0, 0}, {0, 0, 0}, 0.1, 0.9, -1);
  scene.Add({0, inf, 0}, {0, 0, 0}, 0.1, 0.9, -1);
  scene.Add({1e20, 0, 0}, {0, 0, 0}, 0.1, 0.9, -1);
  scene.Add({1e9, 1e9, 0}, {nan, 0, 0}, 0.1, 0.9, -1);
  ThreadPool pool(1);
  const auto result =
      ClusterInstances(scene.model, {}, {}, {}, {}, 0, pool, nullptr);
  ASSERT_TRUE(result.ok()) << result.status().message();
  EXPECT_EQ(result->num_instances, 5);
  for (size_t i = scene.truth.size() - 4; i < scene.truth.size(); ++i) {
    EXPECT_EQ(result->labels[i], -1);
  }
}

TEST(InstanceClusteringTest, EmptyAndTinyModels) {
  ThreadPool pool(1);
  SyntheticGaussians scene;
  for (int count = 0; count < 4; ++count) {
    const auto result =
        ClusterInstances(scene.model, {}, {}, {}, {}, 0, pool, nullptr);
    ASSERT_TRUE(result.ok()) << result.status().message();
    EXPECT_EQ(result->num_instances, 0);
    EXPECT_EQ(result->labels.size(), static_cast<size_t>(count));
    scene.Add({0, 0, static_cast<double>(count)}, {1, 0, 0}, 0.1, 0.5, 0);
  }
}

TEST(InstanceClusteringTest, StopsWhenCancelled) {
  const SyntheticGaussians scene = MakeTableScene();
  ThreadPool pool(1);
  CancellationToken cancellation;
  cancellation.Cancel();
  EXPECT_EQ(
      ClusterInstances(scene.model, {}, {}, {}, {}, 0, pool, &cancellation)
          .status()
          .code(),
      StatusCode::kInterrupted);
}

TEST(InstanceClusteringTest, RefusesBadOptions) {
  ThreadPool pool(1);
  const splat::GaussianModel model;
  InstanceClusteringOptions options;
  options.min_opacity = 1;
  EXPECT_FALSE(
      ClusterInstances(model, {}, {}, {}, options, 0, pool, nullptr).ok());
  options = {};
  options.space.color_weight = std::nan("");
  EXPECT_FALSE(
      ClusterInstances(model, {}, {}, {}, options, 0, pool, nullptr).ok());
  options = {};
  options.planes.min_width = -1;
  EXPECT_FALSE(
      ClusterInstances(model, {}, {}, {}, options, 0, pool, nullptr).ok());
}

}  // namespace
}  // namespace freegs::semantics
