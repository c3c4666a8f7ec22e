// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/smoothing_loss.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "tests/semantics/losses/gradient_check.h"

namespace freegs::semantics {
namespace {

constexpr int kFeatureDim = 6;
constexpr size_t kCount = 30;

double CosineSimilarity(const double* a, const double* b) {
  const double ab = std::inner_product(a, a + kFeatureDim, b, 0.0);
  const double aa = std::inner_product(a, a + kFeatureDim, a, 0.0);
  const double bb = std::inner_product(b, b + kFeatureDim, b, 0.0);
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 2;  // 2: none.
}

// Equation 3 over the pairs that have a cosine.
double Reference(const std::vector<double>& features,
                 const NeighborTable& table,
                 const std::vector<uint32_t>& samples) {
  double sum = 0;
  int count = 0;
  for (const uint32_t i : samples) {
    for (int k = 0; k < table.num_neighbours; ++k) {
      const uint32_t j = table.indices[i * table.num_neighbours + k];
      const double cosine = CosineSimilarity(&features[i * kFeatureDim],
                                             &features[j * kFeatureDim]);
      if (cosine > 1.5) continue;
      sum += 1 - cosine;
      ++count;
    }
  }
  return count > 0 ? sum / count : 0;
}

class SmoothingLossTest : public testing::Test {
 protected:
  ThreadPool pool_{2};
  std::vector<float> features_ = RandomValues(kCount * kFeatureDim, 1);
  std::vector<float> gradients_ =
      std::vector<float>(kCount * kFeatureDim, 0.0f);
  NeighborTable table_ =
      *BuildNeighborTable(RandomValues(3 * kCount, 2), 5, pool_);
  // Some are each other's neighbours, one comes twice.
  std::vector<uint32_t> samples_ = {0, 3, 4, 4, 9, 17, 18, 29};
};

TEST_F(SmoothingLossTest, GradientIsThatOfTheFormula) {
  const StatusOr<double> loss = SmoothingLoss(
      features_, kFeatureDim, table_, samples_, 0.1, pool_, gradients_);
  ASSERT_TRUE(loss.ok()) << loss.status().message();
  EXPECT_NEAR(*loss, Reference(ToDouble(features_), table_, samples_), 1e-9);
  ExpectSameGradient(gradients_,
                     CentralDifferences(
                         [&](const std::vector<double>& x) {
                           return 0.1 * Reference(x, table_, samples_);
                         },
                         ToDouble(features_)));
}

TEST_F(SmoothingLossTest, ZeroVectorsDoNotCount) {
  for (const uint32_t zero : {3u, table_.indices[0]}) {
    std::fill_n(features_.begin() + zero * kFeatureDim, kFeatureDim, 0.0f);
  }
  const StatusOr<double> loss = SmoothingLoss(
      features_, kFeatureDim, table_, samples_, 1.0, pool_, gradients_);
  EXPECT_NEAR(*loss, Reference(ToDouble(features_), table_, samples_), 1e-9);
  EXPECT_TRUE(
      AllZero(std::span(gradients_).subspan(3 * kFeatureDim, kFeatureDim)));
  for (const float g : gradients_) EXPECT_TRUE(std::isfinite(g));

  const std::vector<float> zeros(features_.size(), 0.0f);
  std::vector<float> gradients(features_.size(), 0.0f);
  EXPECT_EQ(*SmoothingLoss(
                zeros, kFeatureDim, table_, samples_, 1.0, pool_, gradients),
            0);
  EXPECT_TRUE(AllZero(gradients));
}

TEST_F(SmoothingLossTest, AlikeIsSmoothHoweverLong) {
  for (size_t i = 0; i < kCount; ++i) {
    for (int k = 0; k < kFeatureDim; ++k) {
      features_[i * kFeatureDim + k] = static_cast<float>((i + 1) * (k + 1));
    }
  }
  EXPECT_NEAR(
      *SmoothingLoss(
          features_, kFeatureDim, table_, samples_, 1.0, pool_, gradients_),
      0,
      1e-12);
  for (const float g : gradients_) EXPECT_NEAR(g, 0, 1e-8);
}

TEST_F(SmoothingLossTest, RefusesWhatDoesNotFit) {
  const auto code = [&](std::span<const float> features,
                        int dim,
                        std::span<const uint32_t> samples,
                        std::span<float> gradients) {
    return SmoothingLoss(features, dim, table_, samples, 1.0, pool_, gradients)
        .status()
        .code();
  };
  const auto bad = StatusCode::kInvalidArgument;
  const std::span<float> out = gradients_;
  EXPECT_EQ(code(features_, 0, samples_, out), bad);
  EXPECT_EQ(code(features_, kFeatureDim + 1, samples_, out), bad);
  EXPECT_EQ(code(features_, kFeatureDim, samples_, out.first(6)), bad);
  EXPECT_EQ(code(features_, kFeatureDim, std::vector<uint32_t>{kCount}, out),
            bad);
  for (const float value : {std::numeric_limits<float>::quiet_NaN(),
                            std::numeric_limits<float>::infinity()}) {
    features_[4 * kFeatureDim] = value;
    EXPECT_EQ(code(features_, kFeatureDim, samples_, out), bad);
  }
  EXPECT_TRUE(AllZero(gradients_));
}

TEST_F(SmoothingLossTest, NothingToSmoothIsZero) {
  EXPECT_EQ(*SmoothingLoss(
                features_, kFeatureDim, table_, {}, 1.0, pool_, gradients_),
            0);
  const NeighborTable alone =
      *BuildNeighborTable(std::vector<float>{1, 2, 3}, 5, pool_);
  EXPECT_EQ(alone.size(), 0u);
  EXPECT_EQ(*SmoothingLoss({}, kFeatureDim, alone, {}, 1.0, pool_, {}), 0);
  std::vector<float> one(kFeatureDim, 0.0f);
  EXPECT_EQ(*SmoothingLoss(std::span(features_).first(kFeatureDim),
                           kFeatureDim,
                           alone,
                           std::vector<uint32_t>{0},
                           1.0,
                           pool_,
                           one),
            0);
  EXPECT_TRUE(BuildNeighborTable({}, 5, pool_).ok());
}

TEST_F(SmoothingLossTest, IsTheSameBytesForAnyNumberOfThreads) {
  constexpr int kWide = 70;
  constexpr size_t kMany = 2000;
  const std::vector<float> features = RandomValues(kMany * kWide, 3);
  const std::vector<float> positions = RandomValues(3 * kMany, 4);
  std::vector<uint32_t> samples(kMany);
  std::iota(samples.begin(), samples.end(), 0u);
  std::vector<std::vector<float>> results;
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    const NeighborTable table = *BuildNeighborTable(positions, 5, pool);
    std::vector<float> gradients(features.size(), 0.0f);
    gradients[0] = static_cast<float>(
        *SmoothingLoss(features, kWide, table, samples, 1.0, pool, gradients));
    results.push_back(gradients);
  }
  EXPECT_EQ(results[1], results[0]);
  EXPECT_EQ(results[2], results[0]);
}

TEST(NeighborTableTest, HoldsTheNearest) {
  ThreadPool pool(2);
  const std::vector<float> line = {0, 0, 0, 1, 0, 0, 3, 0, 0, 7, 0, 0};
  const NeighborTable two = *BuildNeighborTable(line, 2, pool);
  EXPECT_EQ(two.indices, (std::vector<uint32_t>{1, 2, 0, 2, 1, 0, 2, 1}));
  const NeighborTable many = *BuildNeighborTable(line, 9, pool);
  EXPECT_EQ(many.num_neighbours, 3);
  EXPECT_EQ(many.size(), 4u);
  EXPECT_FALSE(BuildNeighborTable(line, 0, pool).ok());
  EXPECT_FALSE(BuildNeighborTable(std::span(line).first(4), 1, pool).ok());
}

TEST(NeighborTableTest, OneThatIsTooFarAwayIsLeftOut) {
  ThreadPool pool(2);
  const std::vector<float> line = {
      0, 0, 0, 1, 0, 0, 0, 2e15F, 0, 3, 0, 0, 7, 0, 0};
  const NeighborTable two = *BuildNeighborTable(line, 2, pool);
  EXPECT_EQ(two.indices, (std::vector<uint32_t>{1, 3, 0, 3, 2, 2, 1, 0, 3, 1}));
  EXPECT_EQ(BuildNeighborTable(line, 9, pool)->num_neighbours, 3);
  EXPECT_EQ(BuildNeighborTable(std::span(line).subspan(3, 6), 1, pool)->size(),
            0u);

  // Its loss is that of no pair, and it changes nothing.
  const std::vector<float> features = RandomValues(5 * kFeatureDim, 7);
  std::vector<float> gradients(features.size(), 0.0f);
  EXPECT_EQ(*SmoothingLoss(features,
                           kFeatureDim,
                           two,
                           std::vector<uint32_t>{2},
                           1.0,
                           pool,
                           gradients),
            0);
  EXPECT_EQ(gradients, std::vector<float>(features.size(), 0.0f));
  const StatusOr<double> all = SmoothingLoss(features,
                                             kFeatureDim,
                                             two,
                                             std::vector<uint32_t>{0, 2, 4},
                                             1.0,
                                             pool,
                                             gradients);
  const StatusOr<double> others = SmoothingLoss(features,
                                                kFeatureDim,
                                                two,
                                                std::vector<uint32_t>{0, 4},
                                                1.0,
                                                pool,
                                                gradients);
  ASSERT_TRUE(all.ok() && others.ok());
  EXPECT_EQ(*all, *others);
  EXPECT_GT(*all, 0);
}

TEST(SampleForSmoothingTest, IsSpreadAndOfTheRightSize) {
  SmoothingOptions options;
  for (const size_t count : {0u, 1u, 63u, 64u, 1000u, 200001u}) {
    const std::vector<uint32_t> samples =
        SampleForSmoothing(options, count, 1, 2);
    const size_t expected =
        std::min<size_t>(count, std::max<size_t>(64, (count + 999) / 1000));
    ASSERT_EQ(samples.size(), expected);
    for (size_t t = 0; t < samples.size(); ++t) {
      EXPECT_LT(samples[t], count);
      EXPECT_TRUE(t == 0 || samples[t - 1] < samples[t]);
    }
    // No two neighbours are farther apart than twice the mean distance, nor is
    // the first from the beginning or the last from the end.
    size_t before = 0;
    size_t largest = 0;
    for (const uint32_t sample : samples) {
      largest = std::max(largest, sample - before);
      before = sample;
    }
    largest = std::max(largest, count - before);
    EXPECT_LE(largest * expected, 2 * count) << count;
  }
  EXPECT_EQ(SampleForSmoothing(options, 1000, 1, 2),
            SampleForSmoothing(options, 1000, 1, 2));
  EXPECT_NE(SampleForSmoothing(options, 1000, 1, 2),
            SampleForSmoothing(options, 1000, 1, 3));
}

TEST(SmoothingOptionsTest, AreChecked) {
  EXPECT_TRUE(SmoothingOptions().Check().ok());
  EXPECT_FALSE(SmoothingOptions{.num_neighbours = 0}.Check().ok());
  EXPECT_FALSE(SmoothingOptions{.fraction = -0.1}.Check().ok());
  EXPECT_FALSE(SmoothingOptions{.fraction = std::nan("")}.Check().ok());
  EXPECT_FALSE(SmoothingOptions{.min_samples = -1}.Check().ok());
}

}  // namespace
}  // namespace freegs::semantics
