// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/semantic_colors.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::semantics {
namespace {

using testing::ElementsAre;

StatusOr<std::vector<float>> Colors(const std::vector<float>& features,
                                    int dim) {
  ThreadPool pool(2);
  return SemanticColors(features, dim, pool);
}

TEST(SemanticColorsTest, LikeMeaningsLookAlikeWhateverTheirLength) {
  const auto colors = Colors({1, 0, 0, 5, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 3}, 3);
  ASSERT_TRUE(colors.ok()) << colors.status().message();
  const auto color = [&](size_t i) {
    return std::vector<float>(
        colors->begin() + 3 * static_cast<int64_t>(i),
        colors->begin() + 3 * static_cast<int64_t>(i) + 3);
  };
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(color(0)[c], color(1)[c], 1e-5);
  EXPECT_THAT(color(3), ElementsAre(0, 0, 0));  // Nothing is known.
  double difference = 0;
  for (int c = 0; c < 3; ++c) {
    difference += std::abs(color(0)[c] - color(2)[c]);
  }
  EXPECT_GT(difference, 0.5);
  for (const float value : *colors) {
    EXPECT_GE(value, 0);
    EXPECT_LE(value, 1);
  }
}

TEST(SemanticColorsTest, StraysDoNotSquashTheRest) {
  RandomStream random(3, 0);
  std::vector<float> features;
  for (int i = 0; i < 400; ++i) {
    const auto angle = static_cast<float>(0.1 * random.Uniform());
    features.insert(features.end(), {std::cos(angle), std::sin(angle)});
  }
  features.insert(features.end(), {-1, 0});
  const auto spread = [](const std::vector<float>& colors) {
    float low = 1;
    float high = 0;
    for (size_t i = 0; i < 400; ++i) {
      low = std::min(low, colors[3 * i]);
      high = std::max(high, colors[3 * i]);
    }
    return high - low;
  };
  EXPECT_GT(spread(*Colors(features, 2)), 0.9);
}

TEST(SemanticColorsTest, WhatDoesNotVaryIsGrey) {
  EXPECT_THAT(*Colors({2, 2}, 1),
              ElementsAre(0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f));
  EXPECT_THAT(*Colors({0, 0}, 2), ElementsAre(0, 0, 0));
  EXPECT_THAT(*Colors({}, 2), ElementsAre());
}

TEST(SemanticColorsTest, WrongArguments) {
  EXPECT_EQ(Colors({1, 2, 3}, 2).status().code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(Colors({1, 2}, 0).status().code(), StatusCode::kInvalidArgument);
  EXPECT_FALSE(Colors({std::numeric_limits<float>::quiet_NaN(), 2}, 2).ok());
}

}  // namespace
}  // namespace freegs::semantics
