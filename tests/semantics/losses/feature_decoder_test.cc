// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/feature_decoder.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "semantics/losses/mlp_gradients.h"
#include "tests/semantics/losses/gradient_check.h"

namespace freegs::semantics {
namespace {

LinearDecoder RandomLinearDecoder() {
  return {.latent_dim = 2,
          .feature_dim = 3,
          .basis = {1, 2, 3, 4, 5, 6},
          .mean = {0.5f, 0, -1}};
}

TEST(FeatureDecoderTest, LinearIsBasisTimesLatentsPlusMean) {
  ThreadPool pool(2);
  const FeatureDecoder decoder(RandomLinearDecoder());
  EXPECT_EQ(decoder.latent_dim(), 2);
  EXPECT_EQ(decoder.feature_dim(), 3);
  EXPECT_TRUE(decoder.linear());
  EXPECT_FALSE(decoder.mlp());
  std::vector<float> features(6);
  ASSERT_TRUE(
      decoder.Decode(std::vector<float>{1, -1, 0, 2}, pool, features).ok());
  EXPECT_EQ(features, (std::vector<float>{-0.5f, -1, -2, 4.5f, 8, 11}));
}

// When the batch is all there is, running statistics of momentum 1 are its own
// but for n / (n - 1) in the variance.
TEST(FeatureDecoderTest, MlpDecodesWithRunningStatistics) {
  ThreadPool pool(2);
  constexpr int64_t kRows = 5000;  // More than go through at once.
  const MlpShape shape = {.latent_dim = 6, .hidden_dim = 20, .feature_dim = 7};
  MlpDecoder mlp = RandomMlpDecoder(shape, 1);
  for (float& shift : mlp.parts().shifts) shift = 0.2f;
  for (float& bias : mlp.parts().output_biases) bias = -0.1f;
  const std::vector<float> latents = RandomValues(kRows * 6, 2);
  std::vector<float> trained(kRows * 7);
  MlpBatch batch;
  MlpForward(mlp, latents, pool, &batch, trained);
  UpdateRunningStatistics(batch, 1.0, &mlp);

  const FeatureDecoder decoder(mlp);
  EXPECT_EQ(decoder.latent_dim(), 6);
  EXPECT_EQ(decoder.feature_dim(), 7);
  std::vector<float> features(kRows * 7);
  ASSERT_TRUE(decoder.Decode(latents, pool, features).ok());
  for (size_t k = 0; k < features.size(); ++k) {
    ASSERT_NEAR(features[k], trained[k], 2e-4) << k;
  }
  // A row alone is decoded as among others.
  std::vector<float> one(7);
  ASSERT_TRUE(
      decoder.Decode(std::span(latents).subspan(6 * 4321, 6), pool, one).ok());
  for (int c = 0; c < 7; ++c) EXPECT_EQ(one[c], features[7 * 4321 + c]);

  ThreadPool single(1);
  std::vector<float> again(features.size());
  ASSERT_TRUE(decoder.Decode(latents, single, again).ok());
  EXPECT_EQ(again, features);
}

TEST(FeatureDecoderTest, FirstFeaturesAreAboutAsLongAsThoseOfClip) {
  ThreadPool pool(2);
  for (const int dim : {16, 128}) {
    const MlpDecoder mlp = RandomMlpDecoder({.latent_dim = dim}, 3);
    const std::vector<float> latents = RandomValues(200 * dim, 2);
    std::vector<float> features(200 * 512);
    MlpBatch batch;
    MlpForward(mlp, latents, pool, &batch, features);
    double sum = 0;
    for (const float value : features) sum += value * value;
    EXPECT_NEAR(std::sqrt(sum / 200), 1, 0.15);
    EXPECT_EQ(mlp.parameters,
              RandomMlpDecoder({.latent_dim = dim}, 3).parameters);
    EXPECT_NE(mlp.parameters,
              RandomMlpDecoder({.latent_dim = dim}, 4).parameters);
  }
}

TEST(FeatureDecoderTest, RefusesSizesThatDisagree) {
  ThreadPool pool(1);
  const FeatureDecoder decoder(RandomLinearDecoder());
  std::vector<float> features(6);
  const auto code = [&](size_t latents, size_t size) {
    return decoder
        .Decode(
            std::vector<float>(latents), pool, std::span(features).first(size))
        .code();
  };
  EXPECT_EQ(code(4, 6), StatusCode::kOk);
  EXPECT_EQ(code(0, 0), StatusCode::kOk);
  EXPECT_EQ(code(3, 6), StatusCode::kInvalidArgument);
  EXPECT_EQ(code(4, 5), StatusCode::kInvalidArgument);
  EXPECT_EQ(code(2, 6), StatusCode::kInvalidArgument);
}

TEST(FeatureDecoderTest, PartsAreChecked) {
  EXPECT_TRUE(RandomLinearDecoder().Check().ok());
  LinearDecoder linear = RandomLinearDecoder();
  linear.mean.pop_back();
  EXPECT_FALSE(linear.Check().ok());
  linear = RandomLinearDecoder();
  linear.basis[2] = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(linear.Check().ok());
  EXPECT_FALSE(LinearDecoder().Check().ok());

  const MlpDecoder good = RandomMlpDecoder({2, 3, 4}, 1);
  EXPECT_TRUE(good.Check().ok());
  MlpDecoder mlp = good;
  mlp.running_variances[1] = -1;
  EXPECT_FALSE(mlp.Check().ok());
  mlp = good;
  mlp.parameters[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(mlp.Check().ok());
  mlp = good;
  mlp.running_means.clear();
  EXPECT_FALSE(mlp.Check().ok());
  EXPECT_FALSE(MlpDecoder().Check().ok());
  EXPECT_FALSE((MlpShape{4, 1 << 20, 4}).Check().ok());
}

}  // namespace
}  // namespace freegs::semantics
