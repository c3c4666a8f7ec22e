// SPDX-License-Identifier: BSD-3-Clause
// Point sets that break clustering programs.

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "semantics/hdbscan/hdbscan.h"

namespace freegs::semantics {
namespace {

HdbscanResult Cluster(const std::vector<float>& points,
                      int dim,
                      const HdbscanOptions& options,
                      int threads = 2) {
  ThreadPool pool(threads);
  const auto result = Hdbscan(points, dim, options, pool, nullptr);
  EXPECT_TRUE(result.ok()) << result.status().message();
  return result.ok() ? *result : HdbscanResult();
}

// Blobs of spread 0.05 within a unit cube, and a tenth of noise.
std::vector<float> Scene(int count, int dim, uint64_t seed) {
  std::vector<float> points;
  for (int i = 0; i < count; ++i) {
    const uint64_t blob = RandomIndex(seed, 0, i, 7);
    for (int k = 0; k < dim; ++k) {
      const uint64_t counter = static_cast<uint64_t>(i) * dim + k;
      points.push_back(static_cast<float>(
          i % 10 == 0 ? RandomUniform(seed, 3, counter)
                      : RandomUniform(seed, 1, blob * dim + k) +
                            0.05 * RandomNormal(seed, 2, counter)));
    }
  }
  return points;
}

void ExpectSane(const HdbscanResult& result, size_t count) {
  ASSERT_EQ(result.labels.size(), count);
  ASSERT_EQ(result.probabilities.size(), count);
  EXPECT_FALSE(std::isnan(result.mst_weight));
  for (size_t i = 0; i < count; ++i) {
    EXPECT_GE(result.labels[i], -1);
    EXPECT_LT(result.labels[i], result.num_clusters);
    EXPECT_EQ(result.probabilities[i] > 0, result.labels[i] >= 0);
    EXPECT_LE(result.probabilities[i], 1);
  }
}

TEST(HdbscanHardCasesTest, AllPointsEqual) {
  // 5000 so that the tree has several levels.
  for (const int count : {2, 16, 17, 300, 5000}) {
    const std::vector<float> points(count * 3, 0.25f);
    const HdbscanResult result =
        Cluster(points, 3, {.min_cluster_size = 5, .min_samples = 5});
    ExpectSane(result, count);
    EXPECT_EQ(result.mst_weight, 0);
  }
}

TEST(HdbscanHardCasesTest, DuplicatesOnly) {
  // Three places, 50 times each, one after the other.
  std::vector<float> points;
  const float places[] = {0, 1, 10};
  for (int i = 0; i < 150; ++i) {
    points.insert(points.end(), {places[i % 3], 0});
  }
  const HdbscanResult result =
      Cluster(points, 2, {.min_cluster_size = 10, .min_samples = 10});
  ExpectSane(result, 150);
  EXPECT_EQ(result.mst_weight, 1 + 9);
}

TEST(HdbscanHardCasesTest, CollinearPoints) {
  // Distances 1, and once 50: along an oblique line in three dimensions.
  std::vector<float> points;
  for (int i = 0; i < 200; ++i) {
    const float t = static_cast<float>(i < 100 ? i : i + 49);
    points.insert(points.end(), {t, 2 * t, -2 * t});
  }
  const HdbscanResult result =
      Cluster(points, 3, {.min_cluster_size = 20, .min_samples = 1});
  ExpectSane(result, 200);
  EXPECT_EQ(result.mst_weight, 3 * (198 + 50));
  ASSERT_EQ(result.num_clusters, 2);
  for (int i = 0; i < 200; ++i) {
    EXPECT_EQ(result.labels[i], result.labels[i < 100 ? 0 : 199]);
  }
}

TEST(HdbscanHardCasesTest, OneToThreePoints) {
  const std::vector<float> points = {0, 0, 3, 4, 3, 5};
  // min_samples is cut to N - 1: three points have core distances sqrt(34), 5
  // and sqrt(34).
  const double weights[] = {0, 5, 2 * std::sqrt(34.0)};
  for (int count = 1; count <= 3; ++count) {
    const HdbscanResult result =
        Cluster({points.begin(), points.begin() + 2 * count},
                2,
                {.min_cluster_size = 2, .min_samples = 20});
    ExpectSane(result, count);
    EXPECT_EQ(result.num_clusters, 0);
    EXPECT_NEAR(result.mst_weight, weights[count - 1], 1e-12);
  }
}

TEST(HdbscanHardCasesTest, MoreSamplesThanPoints) {
  const std::vector<float> points = Scene(60, 3, 5);
  const HdbscanResult many =
      Cluster(points, 3, {.min_cluster_size = 5, .min_samples = 1000000});
  const HdbscanResult all =
      Cluster(points, 3, {.min_cluster_size = 5, .min_samples = 59});
  ExpectSane(many, 60);
  EXPECT_EQ(many.labels, all.labels);
  EXPECT_EQ(many.mst_weight, all.mst_weight);
}

TEST(HdbscanHardCasesTest, ScaleDoesNotMatter) {
  const std::vector<float> points = Scene(3000, 4, 1);
  const HdbscanOptions options{.min_cluster_size = 15, .min_samples = 10};
  const HdbscanResult result = Cluster(points, 4, options);
  EXPECT_GT(result.num_clusters, 3);
  // Powers of two: nothing is rounded. Squares of 2^-70 are below a float.
  for (const float scale : {0x1p48f, 0x1p-70f}) {
    std::vector<float> scaled(points);
    for (float& x : scaled) x *= scale;
    const HdbscanResult other = Cluster(scaled, 4, options);
    EXPECT_EQ(other.labels, result.labels);
    EXPECT_DOUBLE_EQ(other.mst_weight, result.mst_weight * scale);
  }
}

TEST(HdbscanHardCasesTest, FarFromTheOrigin) {
  // 2^20 away, coordinates are multiples of 1/8: ties and duplicates.
  std::vector<float> points = Scene(3000, 3, 2);
  for (float& x : points) x = std::round(64 * x) / 8;
  std::vector<float> far(points);
  for (float& x : far) x += 0x1p20f;
  const HdbscanOptions options{.min_cluster_size = 15, .min_samples = 10};
  const HdbscanResult near_result = Cluster(points, 3, options);
  const HdbscanResult far_result = Cluster(far, 3, options);
  EXPECT_EQ(near_result.labels, far_result.labels);
  EXPECT_EQ(near_result.mst_weight, far_result.mst_weight);
}

TEST(HdbscanHardCasesTest, RefusesWhatIsNotFinite) {
  ThreadPool pool(1);
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(),
                          std::numeric_limits<float>::infinity(),
                          2e15f}) {
    std::vector<float> points = Scene(50, 3, 3);
    points[3 * 20 + 1] = bad;
    const auto result = Hdbscan(points, 3, {}, pool, nullptr);
    EXPECT_EQ(result.status().code(), StatusCode::kInvalidArgument);
    EXPECT_THAT(result.status().message(),
                testing::HasSubstr("coordinate 1 of point 20"));
  }
}

TEST(HdbscanHardCasesTest, ThreadsDoNotMatter) {
  for (const bool ties : {false, true}) {
    std::vector<float> points = Scene(6000, 5, 4);
    if (ties) {
      for (float& x : points) x = std::round(x * 16) / 16;
    }
    for (const ClusterSelection method :
         {ClusterSelection::kExcessOfMass, ClusterSelection::kLeaf}) {
      const HdbscanOptions options{
          .min_cluster_size = 12, .min_samples = 8, .method = method};
      const HdbscanResult one = Cluster(points, 5, options, 1);
      EXPECT_GT(one.num_clusters, 2);
      for (const int threads : {2, 3, 5}) {
        const HdbscanResult other = Cluster(points, 5, options, threads);
        EXPECT_EQ(other.labels, one.labels);
        EXPECT_EQ(other.probabilities, one.probabilities);
        EXPECT_EQ(other.mst_weight, one.mst_weight);
      }
    }
  }
}

}  // namespace
}  // namespace freegs::semantics
