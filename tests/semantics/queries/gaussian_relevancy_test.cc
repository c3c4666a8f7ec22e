// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/queries/gaussian_relevancy.h"

#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "semantics/clip/relevancy.h"

namespace freegs::semantics {
namespace {

// Two latents that are the first two of three feature numbers.
FeatureDecoder TwoOfThree() {
  LinearDecoder linear;
  linear.latent_dim = 2;
  linear.feature_dim = 3;
  linear.basis = {1, 0, 0, 1, 0, 0};
  linear.mean = {0, 0, 0.25F};
  return FeatureDecoder(linear);
}

Idsf Field(std::vector<float> features) {
  Idsf field;
  field.feature_dim = 2;
  field.instances.assign(features.size() / 2, -1);
  field.features = std::move(features);
  return field;
}

TEST(GaussianRelevancy, IsThatOfEveryDecodedFeature) {
  const std::vector<float> texts = {1, 0, 0, 0, 1, 0};
  const std::vector<float> canonical = {0, 0, 1};
  ThreadPool pool(2);
  const auto result = GaussianRelevancy(
      Field({1, 0, 0, 2}), TwoOfThree(), texts, canonical, pool);
  ASSERT_TRUE(result.ok());
  ASSERT_EQ(result->size(), 4u);
  const std::vector<std::vector<float>> features = {{1, 0, 0.25F},
                                                    {0, 2, 0.25F}};
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_FLOAT_EQ((*result)[i],
                    Relevancy(features[i / 2],
                              std::span(texts).subspan(3 * (i % 2), 3),
                              canonical));
  }
  EXPECT_GT((*result)[0], 0.9F);
  EXPECT_LT((*result)[1], 0.2F);
}

TEST(GaussianRelevancy, WhatNoViewShowedAnswersNothing) {
  ThreadPool pool(1);
  const std::vector<float> text = {1, 0, 0};
  const auto result =
      GaussianRelevancy(Field({0, 0, 1, 0}), TwoOfThree(), text, text, pool);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ((*result)[0], 0.0F);
  EXPECT_FLOAT_EQ((*result)[1], 0.5F);
}

TEST(GaussianRelevancy, DoesNotDependOnThreads) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  std::vector<float> features(2 * 20011);
  for (float& value : features) value = normal(random);
  const Idsf field = Field(features);
  const std::vector<float> text = {0.6F, 0.8F, 0};
  const std::vector<float> canonical = {0, 0, 1};
  ThreadPool one(1);
  ThreadPool three(3);
  const auto a = GaussianRelevancy(field, TwoOfThree(), text, canonical, one);
  const auto b = GaussianRelevancy(field, TwoOfThree(), text, canonical, three);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(*a, *b);
  // Gaussians are taken some thousands at a time. The last has its own answer.
  const auto last =
      GaussianRelevancy(Field({features.end() - 2, features.end()}),
                        TwoOfThree(),
                        text,
                        canonical,
                        one);
  ASSERT_TRUE(last.ok());
  EXPECT_EQ(a->back(), last->back());
}

TEST(GaussianRelevancy, RefusesSizesThatDisagree) {
  ThreadPool pool(1);
  const std::vector<float> three = {1, 0, 0};
  const std::vector<float> two = {1, 0};
  Idsf field = Field({1, 0, 0, 2});
  EXPECT_FALSE(GaussianRelevancy(field, TwoOfThree(), two, three, pool).ok());
  EXPECT_FALSE(GaussianRelevancy(field, TwoOfThree(), three, two, pool).ok());
  field.features.pop_back();
  EXPECT_FALSE(GaussianRelevancy(field, TwoOfThree(), three, three, pool).ok());
  field = Field({});
  const auto none = GaussianRelevancy(field, TwoOfThree(), three, three, pool);
  ASSERT_TRUE(none.ok());
  EXPECT_TRUE(none->empty());
}

}  // namespace
}  // namespace freegs::semantics
