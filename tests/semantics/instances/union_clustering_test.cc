// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/union_clustering.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "tests/semantics/synthetic_gaussians.h"

namespace freegs::semantics {
namespace {

const SceneExtent kUnit{Eigen::Vector3d(0, 0, 0), 1};

// Three balls that do not touch, and haze.
SyntheticGaussians ThreeBalls() {
  SyntheticGaussians scene;
  scene.AddSphere({0.5, 0.5, 0}, 0.15, {0.8, 0.1, 0.1}, 1200, 0);
  scene.AddSphere({-0.5, 0.5, 0}, 0.15, {0.1, 0.7, 0.1}, 1100, 1);
  scene.AddSphere({0, -0.5, 0}, 0.15, {0.1, 0.2, 0.8}, 1000, 2);
  for (int i = 0; i < 50; ++i) {
    scene.Add({scene.Uniform(), 0, 1}, {0.5, 0.5, 0.5}, 0.05, 0.03, -1);
  }
  return scene;
}

size_t NumClusters(const std::vector<int32_t>& labels) {
  std::set<int32_t> distinct(labels.begin(), labels.end());
  distinct.erase(-1);
  return distinct.size();
}

TEST(UnionClusteringTest, SeparatesWhatIsApart) {
  const SyntheticGaussians scene = ThreeBalls();
  ThreadPool one(1);
  ThreadPool three(3);
  const auto a = ClusterInUnionSpace(scene.model, {}, kUnit, {}, one, nullptr);
  const auto b =
      ClusterInUnionSpace(scene.model, {}, kUnit, {}, three, nullptr);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a->labels, b->labels);
  EXPECT_EQ(a->scores, b->scores);
  EXPECT_EQ(a->scores.size(), NumClusters(a->labels));
  EXPECT_EQ(a->min_cluster_size, 30);
  // No cluster has Gaussians of two balls, and haze is in none.
  std::set<std::pair<int32_t, int32_t>> pairs;
  for (size_t i = 0; i < scene.truth.size(); ++i) {
    if (a->labels[i] >= 0) pairs.insert({a->labels[i], scene.truth[i]});
  }
  EXPECT_GE(pairs.size(), 3u);
  EXPECT_EQ(pairs.size(), a->scores.size());
}

TEST(UnionClusteringTest, SemanticsSeparateWhatLooksTheSame) {
  SyntheticGaussians scene;
  scene.AddSquare({0, 0, 0}, 1, {0.5, 0.5, 0.5}, 2000, 0);
  scene.AddSquare({1, 0, 0}, 1, {0.5, 0.5, 0.5}, 2000, 1);
  std::vector<float> vectors;
  for (const int32_t object : scene.truth) {
    vectors.insert(vectors.end(), {object == 0 ? 1.0f : 0.0f, 1, 0});
  }
  UnionClusteringOptions options;
  options.space.semantic_weight = 2;
  options.hdbscan.min_cluster_size = 1000;
  ThreadPool pool(2);
  const auto result = ClusterInUnionSpace(
      scene.model, {vectors, 3}, kUnit, options, pool, nullptr);
  ASSERT_TRUE(result.ok());
  ASSERT_EQ(result->scores.size(), 2u);
  for (size_t i = 0; i < scene.truth.size(); ++i) {
    if (result->labels[i] < 0) continue;
    EXPECT_EQ(result->labels[i] == result->labels[0],
              scene.truth[i] == scene.truth[0]);
  }
}

TEST(UnionClusteringTest, RefusesBadOptions) {
  ThreadPool pool(1);
  UnionClusteringOptions options;
  options.space.semantic_weight = std::nan("");
  EXPECT_FALSE(ClusterInUnionSpace({}, {}, kUnit, options, pool, nullptr).ok());
  options = {};
  options.hdbscan.min_samples = 0;
  EXPECT_FALSE(ClusterInUnionSpace({}, {}, kUnit, options, pool, nullptr).ok());
}

}  // namespace
}  // namespace freegs::semantics
