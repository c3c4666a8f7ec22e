// SPDX-License-Identifier: BSD-3-Clause

#include "splat/weights/blending_products.h"

#include <cmath>
#include <cstring>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/splat/test_scene.h"

namespace freegs::splat {
namespace {

std::vector<float> RandomValues(size_t count, uint64_t seed) {
  std::vector<float> values(count);
  for (size_t k = 0; k < count; ++k) {
    values[k] = static_cast<float>(RandomNormal(seed, 0, k));
  }
  return values;
}

// Bytes, not values: memcmp also tells -0 from 0.
bool SameBytes(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

// W^T g in double, for the pixels listed.
std::vector<double> DenseTransposed(const WeightMatrix& weights,
                                    const std::vector<uint32_t>& rows,
                                    const std::vector<float>& pixels,
                                    size_t channels) {
  std::vector<double> sums(weights.num_gaussians * channels, 0.0);
  for (size_t j = 0; j < rows.size(); ++j) {
    for (uint32_t k = weights.pixel_begin[rows[j]];
         k < weights.pixel_begin[rows[j] + 1];
         ++k) {
      for (size_t c = 0; c < channels; ++c) {
        sums[weights.gaussians[k] * channels + c] +=
            static_cast<double>(weights.weights[k]) * pixels[j * channels + c];
      }
    }
  }
  return sums;
}

class BlendingProducts : public testing::Test {
 protected:
  BlendingProducts()
      : pool_(2),
        model_(RandomSceneModel(400, 0, 7)),
        camera_(TestCamera(75, 53)),
        weights_(*ComputeBlendingWeights(
            model_, camera_, TestPose(), RenderOptions(), pool_)),
        w_(weights_.matrix()) {}

  size_t num_pixels() const { return w_.num_pixels(); }

  ThreadPool pool_;
  GaussianModel model_;
  Pinhole camera_;
  BlendingWeights weights_;
  WeightMatrix w_;
};

// Widths that end in every kind of vector.
constexpr int kChannels[] = {1, 3, 6, 16, 37, 77, 128};

TEST_F(BlendingProducts, BlendFeaturesAsTheRendererDoes) {
  for (const int channels : kChannels) {
    const std::vector<float> features =
        RandomValues(model_.size() * channels, 1);
    const RenderedView view = RenderView(model_,
                                         camera_,
                                         TestPose(),
                                         RenderOptions(),
                                         pool_,
                                         {features, channels});
    std::vector<float> pixels(num_pixels() * channels, 7.0f);
    ASSERT_TRUE(Multiply(w_, features, channels, pool_, pixels).ok());
    for (size_t k = 0; k < pixels.size(); ++k) {
      ASSERT_NEAR(pixels[k], view.features.data()[k], 1e-5) << channels;
    }
  }
}

TEST_F(BlendingProducts, TransposedIsTheAdjoint) {
  for (const int channels : kChannels) {
    const std::vector<float> f = RandomValues(model_.size() * channels, 2);
    const std::vector<float> g = RandomValues(num_pixels() * channels, 3);
    std::vector<float> wf(g.size());
    std::vector<float> wtg(f.size(), 0.0f);
    ASSERT_TRUE(Multiply(w_, f, channels, pool_, wf).ok());
    ASSERT_TRUE(AddMultiplyTransposed(w_, g, channels, pool_, wtg).ok());
    double left = 0, right = 0, size = 0;
    for (size_t k = 0; k < g.size(); ++k) {
      left += static_cast<double>(wf[k]) * g[k];
      size += std::abs(static_cast<double>(wf[k]) * g[k]);
    }
    for (size_t k = 0; k < f.size(); ++k) {
      right += static_cast<double>(f[k]) * wtg[k];
    }
    EXPECT_NEAR(left, right, 1e-6 * size) << channels;
  }
}

TEST_F(BlendingProducts, TransposedAddsTheSumsOverPixels) {
  std::vector<uint32_t> rows(num_pixels());
  for (size_t p = 0; p < rows.size(); ++p) rows[p] = static_cast<uint32_t>(p);
  for (const int channels : kChannels) {
    const std::vector<float> g = RandomValues(num_pixels() * channels, 4);
    const std::vector<double> expected =
        DenseTransposed(w_, rows, g, static_cast<size_t>(channels));
    std::vector<float> sums(expected.size(), 0.5f);
    ASSERT_TRUE(AddMultiplyTransposed(w_, g, channels, pool_, sums).ok());
    for (size_t k = 0; k < sums.size(); ++k) {
      ASSERT_NEAR(sums[k], 0.5 + expected[k], 1e-4) << channels;
    }
  }
}

TEST_F(BlendingProducts, SomePixelsAreThoseOfAll) {
  constexpr int kWidth = 37;
  // In no order, with repetitions.
  std::vector<uint32_t> rows(500);
  for (size_t j = 0; j < rows.size(); ++j) {
    rows[j] = static_cast<uint32_t>(RandomIndex(5, 0, j, num_pixels()));
  }
  rows[9] = rows[8];
  const std::vector<float> f = RandomValues(model_.size() * kWidth, 5);
  std::vector<float> all(num_pixels() * kWidth);
  std::vector<float> some(rows.size() * kWidth);
  ASSERT_TRUE(Multiply(w_, f, kWidth, pool_, all).ok());
  ASSERT_TRUE(MultiplyAt(w_, rows, f, kWidth, pool_, some).ok());
  for (size_t j = 0; j < rows.size(); ++j) {
    EXPECT_EQ(0,
              std::memcmp(&some[j * kWidth],
                          &all[rows[j] * size_t{kWidth}],
                          kWidth * sizeof(float)));
  }

  const std::vector<float> g = RandomValues(rows.size() * kWidth, 6);
  const std::vector<double> expected = DenseTransposed(w_, rows, g, kWidth);
  std::vector<float> sums(f.size(), 0.0f);
  ASSERT_TRUE(AddMultiplyTransposedAt(w_, rows, g, kWidth, pool_, sums).ok());
  for (size_t k = 0; k < sums.size(); ++k) {
    ASSERT_NEAR(sums[k], expected[k], 1e-5);
  }
}

TEST_F(BlendingProducts, SameBytesForAnyNumberOfThreads) {
  constexpr int kWidth = 77;
  const std::vector<float> f = RandomValues(model_.size() * kWidth, 8);
  const std::vector<float> g = RandomValues(num_pixels() * kWidth, 9);
  const std::vector<uint32_t> rows = {5, 3, 700, 3};
  const std::vector<float> g_rows = RandomValues(rows.size() * kWidth, 10);
  std::vector<std::vector<float>> expected;
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    std::vector<std::vector<float>> results = {
        std::vector<float>(g.size()),
        std::vector<float>(g_rows.size()),
        std::vector<float>(f.size(), 0.0f),
        std::vector<float>(f.size(), 0.0f)};
    ASSERT_TRUE(Multiply(w_, f, kWidth, pool, results[0]).ok());
    ASSERT_TRUE(MultiplyAt(w_, rows, f, kWidth, pool, results[1]).ok());
    ASSERT_TRUE(AddMultiplyTransposed(w_, g, kWidth, pool, results[2]).ok());
    ASSERT_TRUE(
        AddMultiplyTransposedAt(w_, rows, g_rows, kWidth, pool, results[3])
            .ok());
    if (threads == 1) expected = results;
    for (size_t k = 0; k < results.size(); ++k) {
      EXPECT_TRUE(SameBytes(results[k], expected[k])) << k;
    }
  }
}

TEST_F(BlendingProducts, GaussianWeightsAreColumnSums) {
  std::vector<double> sums(model_.size(), 1.0);
  ASSERT_TRUE(AddGaussianWeights(w_, sums).ok());
  std::vector<double> expected(model_.size(), 1.0);
  for (size_t k = 0; k < w_.num_weights(); ++k) {
    expected[w_.gaussians[k]] += w_.weights[k];
  }
  EXPECT_EQ(sums, expected);
}

TEST_F(BlendingProducts, RefuseSizesThatDisagree) {
  std::vector<float> f(model_.size() * 3), g(num_pixels() * 3);
  const auto refused = [](const Status& status) {
    return status.code() == StatusCode::kInvalidArgument;
  };
  EXPECT_TRUE(refused(Multiply(w_, f, 2, pool_, g)));
  EXPECT_TRUE(refused(Multiply(w_, f, 0, pool_, g)));
  EXPECT_TRUE(refused(Multiply(w_, f, -3, pool_, g)));
  EXPECT_TRUE(refused(Multiply(w_, g, 3, pool_, g)));
  EXPECT_TRUE(refused(AddMultiplyTransposed(w_, f, 3, pool_, f)));
  const std::vector<uint32_t> rows = {0, static_cast<uint32_t>(num_pixels())};
  std::vector<float> two(2 * 3);
  EXPECT_TRUE(refused(MultiplyAt(w_, rows, f, 3, pool_, two)));
  EXPECT_TRUE(refused(AddMultiplyTransposedAt(w_, rows, two, 3, pool_, f)));
  std::vector<double> sums(3);
  EXPECT_TRUE(refused(AddGaussianWeights(w_, sums)));
  WeightMatrix cut = w_;
  cut.weights = cut.weights.first(cut.weights.size() - 1);
  EXPECT_TRUE(refused(Multiply(cut, f, 3, pool_, g)));
}

}  // namespace
}  // namespace freegs::splat
