// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/mlp_gradients.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/semantics/losses/gradient_check.h"

namespace freegs::semantics {
namespace {

constexpr MlpShape kSmallShape{
    .latent_dim = 4, .hidden_dim = 9, .feature_dim = 6};
constexpr size_t kBatchRows = 11;

// A decoder none of whose parameters is 0 or 1.
MlpDecoder TestDecoder() {
  MlpDecoder decoder = RandomMlpDecoder(kSmallShape, 5);
  const std::vector<float> noise = RandomValues(decoder.parameters.size(), 6);
  for (size_t k = 0; k < noise.size(); ++k) {
    decoder.parameters[k] += 0.3f * noise[k];
  }
  return decoder;
}

// The MLP as its definition reads, with the statistics of the batch.
std::vector<double> Reference(const std::vector<double>& parameters,
                              const std::vector<double>& latents) {
  const auto [dim, hidden, channels] = kSmallShape;
  const double* w1 = parameters.data();
  const double* scales = w1 + hidden * dim;
  const double* shifts = scales + hidden;
  const double* w2 = shifts + hidden;
  const double* biases = w2 + channels * hidden;
  const size_t rows = latents.size() / dim;
  std::vector<double> features(rows * channels);
  for (size_t p = 0; p < rows; ++p) {
    for (int c = 0; c < channels; ++c) features[p * channels + c] = biases[c];
  }
  for (int h = 0; h < hidden; ++h) {
    std::vector<double> z(rows, 0.0);
    double mean = 0;
    for (size_t p = 0; p < rows; ++p) {
      for (int k = 0; k < dim; ++k)
        z[p] += w1[h * dim + k] * latents[p * dim + k];
      mean += z[p] / static_cast<double>(rows);
    }
    double variance = 0;
    for (const double value : z) {
      variance += (value - mean) * (value - mean) / static_cast<double>(rows);
    }
    for (size_t p = 0; p < rows; ++p) {
      const double y =
          scales[h] * (z[p] - mean) / std::sqrt(variance + 1e-5) + shifts[h];
      for (int c = 0; c < channels; ++c) {
        features[p * channels + c] += w2[c * hidden + h] * std::max(y, 0.0);
      }
    }
  }
  return features;
}

class MlpGradientsTest : public testing::Test {
 protected:
  void Run(int threads, size_t rows) {
    ThreadPool pool(threads);
    const std::span<const float> latents =
        std::span(latents_).first(rows * kSmallShape.latent_dim);
    features_.assign(rows * kSmallShape.feature_dim, 0.0f);
    parameter_gradients_.assign(decoder_.parameters.size(), 0.0f);
    latent_gradients_.assign(latents.size(), 0.0f);
    MlpForward(decoder_, latents, pool, &batch_, features_);
    MlpBackward(decoder_,
                batch_,
                std::span(feature_gradients_).first(features_.size()),
                pool,
                parameter_gradients_,
                latent_gradients_);
  }

  // sum of features times what is given as dL/dfeatures.
  double Objective(const std::vector<double>& parameters,
                   const std::vector<double>& latents) const {
    const std::vector<double> features = Reference(parameters, latents);
    double sum = 0;
    for (size_t k = 0; k < features.size(); ++k) {
      sum += features[k] * feature_gradients_[k];
    }
    return sum;
  }

  void ExpectAsByFormula(double tolerance) {
    const std::vector<double> parameters = ToDouble(decoder_.parameters);
    const std::vector<double> latents = ToDouble(latents_);
    const std::vector<double> expected = Reference(parameters, latents);
    for (size_t k = 0; k < expected.size(); ++k) {
      ASSERT_NEAR(features_[k], expected[k], 1e-5);
    }
    ExpectSameGradient(
        parameter_gradients_,
        CentralDifferences(
            [&](const std::vector<double>& x) { return Objective(x, latents); },
            parameters,
            1e-6),
        tolerance);
    ExpectSameGradient(latent_gradients_,
                       CentralDifferences(
                           [&](const std::vector<double>& x) {
                             return Objective(parameters, x);
                           },
                           latents,
                           1e-6),
                       tolerance);
  }

  MlpDecoder decoder_ = TestDecoder();
  std::vector<float> latents_ =
      RandomValues(kBatchRows * kSmallShape.latent_dim, 1);
  std::vector<float> feature_gradients_ =
      RandomValues(kBatchRows * kSmallShape.feature_dim, 2);
  MlpBatch batch_;
  std::vector<float> features_;
  std::vector<float> parameter_gradients_;
  std::vector<float> latent_gradients_;
};

TEST_F(MlpGradientsTest, AreThoseOfTheFormula) {
  Run(2, kBatchRows);
  ExpectAsByFormula(1e-5);
}

TEST_F(MlpGradientsTest, AreThoseOfTheFormulaFarFromTheOrigin) {
  for (float& value : latents_) value += 10;  // The mean takes it out.
  Run(2, kBatchRows);
  ExpectAsByFormula(1e-4);
}

TEST_F(MlpGradientsTest, AreAddedToWhatIsThere) {
  Run(1, kBatchRows);
  ThreadPool pool(1);
  std::vector<float> twice = parameter_gradients_;
  std::vector<float> latents_twice = latent_gradients_;
  MlpBackward(decoder_, batch_, feature_gradients_, pool, twice, latents_twice);
  for (size_t k = 0; k < twice.size(); ++k) {
    EXPECT_NEAR(twice[k], 2 * parameter_gradients_[k], 1e-5);
  }
  for (size_t k = 0; k < latents_twice.size(); ++k) {
    EXPECT_NEAR(latents_twice[k], 2 * latent_gradients_[k], 1e-5);
  }
}

TEST_F(MlpGradientsTest, AreFiniteForDegenerateBatches) {
  const auto finite = [](std::span<const float> values) {
    return std::all_of(values.begin(), values.end(), [](float value) {
      return std::isfinite(value);
    });
  };
  Run(2, 0);
  EXPECT_TRUE(AllZero(parameter_gradients_));
  EXPECT_TRUE(batch_.statistics_finite());
  UpdateRunningStatistics(batch_, 0.1, &decoder_);
  EXPECT_EQ(decoder_.running_means, std::vector<float>(9, 0.0f));

  Run(2, 1);  // One row normalises to 0: nothing tells latents apart.
  EXPECT_TRUE(finite(features_) && finite(parameter_gradients_));
  EXPECT_TRUE(AllZero(latent_gradients_));
  UpdateRunningStatistics(batch_, 0.1, &decoder_);
  EXPECT_EQ(decoder_.running_variances, std::vector<float>(9, 1.0f));

  std::fill(latents_.begin(), latents_.end(), 0.0f);  // What nothing covers.
  Run(2, kBatchRows);
  EXPECT_TRUE(finite(features_) && finite(parameter_gradients_) &&
              finite(latent_gradients_));
}

TEST_F(MlpGradientsTest, RunningStatisticsAreThoseOfPastBatches) {
  Run(2, kBatchRows);
  UpdateRunningStatistics(batch_, 0.25, &decoder_);
  for (int h = 0; h < kSmallShape.hidden_dim; ++h) {
    const double unbiased = batch_.variances[h] * kBatchRows / (kBatchRows - 1);
    EXPECT_NEAR(decoder_.running_means[h], 0.25 * batch_.means[h], 1e-6);
    EXPECT_NEAR(decoder_.running_variances[h], 0.75 + 0.25 * unbiased, 1e-6);
  }
}

TEST_F(MlpGradientsTest, AreTheSameBytesForAnyNumberOfThreads) {
  decoder_ = RandomMlpDecoder(
      {.latent_dim = 5, .hidden_dim = 70, .feature_dim = 130}, 1);
  const std::vector<float> latents = RandomValues(500 * 5, 2);
  const std::vector<float> gradients = RandomValues(500 * 130, 3);
  std::vector<std::vector<float>> results;
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    std::vector<float> features(500 * 130);
    std::vector<float> of_parameters(decoder_.parameters.size(), 0.0f);
    std::vector<float> all(latents.size(), 0.0f);
    MlpForward(decoder_, latents, pool, &batch_, features);
    MlpBackward(decoder_, batch_, gradients, pool, of_parameters, all);
    all.insert(all.end(), features.begin(), features.end());
    all.insert(all.end(), of_parameters.begin(), of_parameters.end());
    results.push_back(all);
  }
  EXPECT_EQ(results[1], results[0]);
  EXPECT_EQ(results[2], results[0]);
}

}  // namespace
}  // namespace freegs::semantics
