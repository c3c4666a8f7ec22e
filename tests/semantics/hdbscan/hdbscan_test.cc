// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/hdbscan/hdbscan.h"

#include <cmath>
#include <set>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::semantics {
namespace {

// Appends a round blob in two dimensions.
void AddBlob(
    double x, double y, double sigma, int count, std::vector<float>* points) {
  const uint64_t stream = points->size();
  for (int i = 0; i < count; ++i) {
    points->push_back(
        static_cast<float>(x + sigma * RandomNormal(7, stream, 2 * i)));
    points->push_back(
        static_cast<float>(y + sigma * RandomNormal(7, stream, 2 * i + 1)));
  }
}

TEST(HdbscanTest, TwoBlobsAndAStrayPoint) {
  std::vector<float> points;
  AddBlob(0, 0, 0.1, 100, &points);
  AddBlob(5, 0, 0.3, 80, &points);
  points.insert(points.end(), {2.5f, 40.0f});
  ThreadPool pool(2);
  const auto result = Hdbscan(
      points, 2, {.min_cluster_size = 10, .min_samples = 5}, pool, nullptr);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->num_clusters, 2);
  EXPECT_EQ(result->labels[180], -1);
  EXPECT_EQ(result->probabilities[180], 0);
  EXPECT_NE(result->labels[0], result->labels[100]);
  for (int i = 0; i < 180; ++i) {
    EXPECT_EQ(result->labels[i], result->labels[i < 100 ? 0 : 100]);
    EXPECT_GT(result->probabilities[i], 0);
    EXPECT_LE(result->probabilities[i], 1);
  }
}

// Three blobs of which two are close: a tree of two levels.
std::vector<float> NestedBlobs() {
  std::vector<float> points;
  AddBlob(0, 0, 0.1, 60, &points);
  AddBlob(1.2, 0, 0.1, 60, &points);
  AddBlob(20, 0, 0.1, 60, &points);
  return points;
}

int NumClusters(const std::vector<float>& points,
                const HdbscanOptions& options) {
  ThreadPool pool(1);
  const auto result = Hdbscan(points, 2, options, pool, nullptr);
  return result.ok() ? result->num_clusters : -1;
}

TEST(HdbscanTest, EpsilonMergesWhatIsCloser) {
  HdbscanOptions options{.min_cluster_size = 20, .min_samples = 5};
  EXPECT_EQ(NumClusters(NestedBlobs(), options), 3);
  options.cluster_selection_epsilon = 2;
  EXPECT_EQ(NumClusters(NestedBlobs(), options), 2);
  // Never the root: the children of the root are the coarsest clusters.
  options.cluster_selection_epsilon = 1000;
  EXPECT_EQ(NumClusters(NestedBlobs(), options), 2);
}

TEST(HdbscanTest, MaxClusterSizeSplitsOrDropsLargeClusters) {
  std::vector<float> points;
  AddBlob(0, 0, 0.1, 60, &points);
  AddBlob(0.45, 0, 0.1, 60, &points);
  AddBlob(20, 0, 0.1, 60, &points);
  HdbscanOptions options{.min_cluster_size = 20, .min_samples = 5};
  options.cluster_selection_epsilon = 0;
  // Two blobs are so close that they are one cluster if it may be so large.
  EXPECT_EQ(NumClusters(points, options), 2);
  options.max_cluster_size = 120;
  EXPECT_EQ(NumClusters(points, options), 2);
  options.max_cluster_size = 100;
  EXPECT_EQ(NumClusters(points, options), 3);
  // Leaves that are too large become noise.
  options.max_cluster_size = 30;
  EXPECT_EQ(NumClusters(points, options), 0);
}

TEST(HdbscanTest, TooFewPointsAreNoise) {
  for (const int count : {0, 1, 2, 19}) {
    std::vector<float> points;
    AddBlob(0, 0, 1, count, &points);
    ThreadPool pool(1);
    const auto result = Hdbscan(points, 2, {}, pool, nullptr);
    ASSERT_TRUE(result.ok());
    EXPECT_EQ(result->num_clusters, 0);
    EXPECT_THAT(result->labels, testing::Each(-1));
    EXPECT_EQ(result->labels.size(), static_cast<size_t>(count));
  }
}

TEST(HdbscanTest, OneBlobIsNoCluster) {
  // The root is never selected; a uniform grid has no other cluster.
  std::vector<float> points;
  for (int i = 0; i < 10; ++i) {
    for (int j = 0; j < 10; ++j) {
      points.push_back(static_cast<float>(i));
      points.push_back(static_cast<float>(j));
    }
  }
  EXPECT_EQ(NumClusters(points, {.min_cluster_size = 60, .min_samples = 3}), 0);
}

TEST(HdbscanTest, RefusesBadOptions) {
  ThreadPool pool(1);
  const std::vector<float> points(20, 0.0f);
  for (const HdbscanOptions& options :
       {HdbscanOptions{.min_cluster_size = 1},
        HdbscanOptions{.min_samples = 0},
        HdbscanOptions{.cluster_selection_epsilon = -1},
        HdbscanOptions{.cluster_selection_epsilon = std::nan("")},
        HdbscanOptions{.max_cluster_size = -1}}) {
    EXPECT_EQ(Hdbscan(points, 2, options, pool, nullptr).status().code(),
              StatusCode::kInvalidArgument);
  }
  EXPECT_FALSE(Hdbscan(points, 3, {}, pool, nullptr).ok());
}

}  // namespace
}  // namespace freegs::semantics
