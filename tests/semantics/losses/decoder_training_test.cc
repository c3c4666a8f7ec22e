// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/decoder_training.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "semantics/losses/pixel_distillation_loss.h"
#include "tests/semantics/losses/gradient_check.h"

namespace freegs::semantics {
namespace {

constexpr MlpShape kShape{.latent_dim = 4, .hidden_dim = 32, .feature_dim = 8};
constexpr size_t kRows = 200;

FeatureDecoder TestMlp() { return FeatureDecoder(RandomMlpDecoder(kShape, 1)); }

FeatureDecoder TestLinear() {
  return FeatureDecoder(LinearDecoder{.latent_dim = 4,
                                      .feature_dim = 8,
                                      .basis = RandomValues(32, 3),
                                      .mean = RandomValues(8, 4)});
}

// Learns latents and decoder for given features; returns the last loss.
double Learn(int steps,
             ThreadPool& pool,
             DecoderTraining* training,
             std::vector<float>* latents) {
  const std::vector<float> targets = RandomValues(kRows * 8, 2);
  ArrayAdamState adam = ArrayAdamState::OfSize(latents->size());
  double loss = 0;
  for (int step = 0; step < steps; ++step) {
    const auto features = training->Forward(*latents, pool);
    EXPECT_TRUE(features.ok());
    std::vector<float> gradients(features->size(), 0.0f);
    std::vector<float> latent_gradients(latents->size(), 0.0f);
    loss = *PixelDistillationLoss(*features, targets, 8, 1.0, pool, gradients);
    EXPECT_TRUE(training->Backward(gradients, pool, latent_gradients).ok());
    EXPECT_TRUE(training->Step(pool).ok());
    StepArrayAdam({}, 0.02, latent_gradients, pool, &adam, *latents);
  }
  return loss;
}

TEST(DecoderTrainingTest, LearnsMlpAndLatents) {
  ThreadPool pool(2);
  FeatureDecoder decoder = TestMlp();
  std::vector<float> latents = RandomValues(kRows * 4, 5);
  DecoderTraining training({.learning_rate = 0.01}, &decoder);
  const double before = Learn(1, pool, &training, &latents);
  EXPECT_LT(Learn(300, pool, &training, &latents), 0.6 * before);
  EXPECT_TRUE(decoder.mlp()->Check().ok());
  EXPECT_EQ(training.adam().steps, 301);
}

TEST(DecoderTrainingTest, LearnsLatentsThroughALinearDecoder) {
  ThreadPool pool(2);
  FeatureDecoder decoder = TestLinear();
  const std::vector<float> basis = decoder.linear()->basis;
  std::vector<float> latents = RandomValues(kRows * 4, 5);
  DecoderTraining training({}, &decoder);
  const double before = Learn(1, pool, &training, &latents);
  EXPECT_LT(Learn(300, pool, &training, &latents), 0.6 * before);
  EXPECT_EQ(decoder.linear()->basis, basis);
}

TEST(DecoderTrainingTest, LinearGradientIsTheTransposedBasis) {
  ThreadPool pool(2);
  FeatureDecoder decoder = TestLinear();
  DecoderTraining training({}, &decoder);
  ASSERT_TRUE(training.Forward(RandomValues(12, 1), pool).ok());
  const std::vector<float> gradients = RandomValues(24, 2);
  std::vector<float> latent_gradients(12, 0.0f);
  ASSERT_TRUE(training.Backward(gradients, pool, latent_gradients).ok());
  const std::vector<float>& basis = decoder.linear()->basis;
  for (int p = 0; p < 3; ++p) {
    for (int k = 0; k < 4; ++k) {
      double sum = 0;
      for (int c = 0; c < 8; ++c)
        sum += gradients[p * 8 + c] * basis[c * 4 + k];
      EXPECT_NEAR(latent_gradients[p * 4 + k], sum, 1e-5);
    }
  }
}

TEST(DecoderTrainingTest, GoesOnFromAStoredState) {
  ThreadPool pool(2);
  std::vector<float> straight = RandomValues(kRows * 4, 5);
  FeatureDecoder whole = TestMlp();
  DecoderTraining once({}, &whole);
  Learn(1, pool, &once, &straight);
  std::vector<float> resumed = straight;
  FeatureDecoder half = whole;
  DecoderTraining again({}, &half);
  ASSERT_TRUE(again.set_adam(once.adam()).ok());
  Learn(3, pool, &once, &straight);
  ThreadPool single(1);
  Learn(3, single, &again, &resumed);
  EXPECT_EQ(half.mlp()->parameters, whole.mlp()->parameters);
  EXPECT_EQ(half.mlp()->running_variances, whole.mlp()->running_variances);
  EXPECT_EQ(resumed, straight);
  EXPECT_FALSE(again.set_adam(ArrayAdamState::OfSize(3)).ok());
}

TEST(DecoderTrainingTest, RefusesWhatIsNotFiniteAndStaysAsItWas) {
  ThreadPool pool(2);
  FeatureDecoder decoder = TestMlp();
  const MlpDecoder before = *decoder.mlp();
  DecoderTraining training({}, &decoder);
  std::vector<float> latents = RandomValues(kRows * 4, 5);
  latents[17] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(training.Forward(latents, pool).status().code(),
            StatusCode::kInvalidArgument);
  latents[17] = 1e25f;  // Its square is no float.
  EXPECT_EQ(training.Forward(latents, pool).status().code(),
            StatusCode::kInvalidArgument);
  EXPECT_EQ(decoder.mlp()->running_means, before.running_means);
  EXPECT_EQ(decoder.mlp()->running_variances, before.running_variances);

  latents[17] = 0;
  ASSERT_TRUE(training.Forward(latents, pool).ok());
  std::vector<float> gradients(kRows * 8, 1.0f);
  gradients[3] = std::numeric_limits<float>::infinity();
  std::vector<float> latent_gradients(latents.size(), 0.0f);
  ASSERT_TRUE(training.Backward(gradients, pool, latent_gradients).ok());
  EXPECT_EQ(training.Step(pool).code(), StatusCode::kUnusableResult);
  EXPECT_EQ(decoder.mlp()->parameters, before.parameters);
  EXPECT_TRUE(training.Step(pool).ok());  // Forgotten.
  gradients[3] = 1e25f;
  ASSERT_TRUE(training.Backward(gradients, pool, latent_gradients).ok());
  EXPECT_EQ(training.Step(pool).code(), StatusCode::kUnusableResult);
  EXPECT_TRUE(AllZero(training.adam().second_moments));
  EXPECT_TRUE(decoder.mlp()->Check().ok());
}

TEST(DecoderTrainingTest, RefusesSizesThatDisagree) {
  ThreadPool pool(1);
  FeatureDecoder decoder = TestMlp();
  DecoderTraining training({}, &decoder);
  EXPECT_FALSE(training.Forward(RandomValues(7, 1), pool).ok());
  ASSERT_TRUE(training.Forward(RandomValues(8, 1), pool).ok());
  std::vector<float> latent_gradients(8);
  EXPECT_FALSE(
      training.Backward(RandomValues(8, 1), pool, latent_gradients).ok());
  EXPECT_FALSE(training
                   .Backward(RandomValues(16, 1),
                             pool,
                             std::span(latent_gradients).first(4))
                   .ok());
  EXPECT_TRUE(
      training.Backward(RandomValues(16, 1), pool, latent_gradients).ok());
}

TEST(DecoderTrainingTest, AnEmptyBatchChangesNothing) {
  ThreadPool pool(1);
  FeatureDecoder decoder = TestMlp();
  const MlpDecoder before = *decoder.mlp();
  DecoderTraining training({}, &decoder);
  const auto features = training.Forward({}, pool);
  ASSERT_TRUE(features.ok());
  EXPECT_TRUE(features->empty());
  EXPECT_TRUE(training.Backward({}, pool, {}).ok());
  EXPECT_TRUE(training.Step(pool).ok());
  EXPECT_EQ(decoder.mlp()->parameters, before.parameters);
  EXPECT_EQ(decoder.mlp()->running_variances, before.running_variances);
}

TEST(DecoderTrainingTest, OptionsAreChecked) {
  EXPECT_TRUE(DecoderTrainingOptions().Check().ok());
  EXPECT_FALSE(DecoderTrainingOptions{.learning_rate = -1}.Check().ok());
}

// Two steps of Adam as Kingma and Ba write them.
TEST(ArrayAdamTest, AgreesWithTheFormula) {
  ThreadPool pool(2);
  constexpr size_t kSize = 40000;  // More than one piece.
  const splat::AdamOptions options = {.epsilon = 1e-8};
  std::vector<float> parameters = RandomValues(kSize, 1);
  std::vector<double> expected = ToDouble(parameters);
  std::vector<double> m(kSize, 0.0);
  std::vector<double> v(kSize, 0.0);
  ArrayAdamState state = ArrayAdamState::OfSize(kSize);
  for (int t = 1; t <= 2; ++t) {
    const std::vector<float> gradients = RandomValues(kSize, 10 + t);
    StepArrayAdam(options, 0.01, gradients, pool, &state, parameters);
    for (size_t k = 0; k < kSize; ++k) {
      const double g = gradients[k];
      m[k] = 0.9 * m[k] + 0.1 * g;
      v[k] = 0.999 * v[k] + 0.001 * g * g;
      expected[k] -= 0.01 * (m[k] / (1 - std::pow(0.9, t))) /
                     (std::sqrt(v[k] / (1 - std::pow(0.999, t))) + 1e-8);
    }
  }
  for (size_t k = 0; k < kSize; ++k) {
    ASSERT_NEAR(parameters[k], expected[k], 1e-6) << k;
  }
}

}  // namespace
}  // namespace freegs::semantics
