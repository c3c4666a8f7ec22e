// SPDX-License-Identifier: BSD-3-Clause
// Who is drawn how often, and who is kept.

#include "splat/density/simplification.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::splat {
namespace {

using Indices = std::vector<uint32_t>;

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// How often each of the importances is among `count` drawn.
std::vector<double> Frequencies(const std::vector<float>& importance,
                                size_t count,
                                int trials) {
  std::vector<double> drawn(importance.size());
  for (int trial = 0; trial < trials; ++trial) {
    for (const uint32_t i : SampleByImportance(importance, count, 3, trial)) {
      drawn[i] += 1;
    }
  }
  return drawn;
}

TEST(SampleByImportanceTest, OneIsDrawnInProportion) {
  const std::vector<float> importance = {1, 2, 3, 4, 0, 10, 20, 60};
  constexpr int kTrials = 20000;
  const std::vector<double> drawn = Frequencies(importance, 1, kTrials);
  EXPECT_EQ(drawn[4], 0.0);
  double chi_square = 0;
  for (size_t i = 0; i < importance.size(); ++i) {
    if (importance[i] == 0) continue;
    const double expected = kTrials * importance[i] / 100.0;
    chi_square += (drawn[i] - expected) * (drawn[i] - expected) / expected;
  }
  EXPECT_LT(chi_square, 22.5);  // 6 degrees of freedom, p = 0.001.
}

TEST(SampleByImportanceTest, TheSecondIsDrawnInProportionAmongTheRest) {
  const std::vector<float> importance = {0.1f, 0.2f, 0.3f, 0.4f};
  constexpr int kTrials = 20000;
  const std::vector<double> drawn = Frequencies(importance, 2, kTrials);
  for (size_t i = 0; i < importance.size(); ++i) {
    double chance = importance[i];
    for (size_t j = 0; j < importance.size(); ++j) {
      if (j == i) continue;
      chance += importance[j] * importance[i] / (1.0 - importance[j]);
    }
    const double deviation = std::sqrt(kTrials * chance * (1 - chance));
    EXPECT_NEAR(drawn[i], kTrials * chance, 4 * deviation) << i;
  }
}

TEST(SampleByImportanceTest, AscendingDistinctAndRepeatable) {
  std::vector<float> importance(5000);
  for (size_t i = 0; i < importance.size(); ++i) {
    importance[i] = static_cast<float>(RandomUniform(1, 1, i));
  }
  const Indices drawn = SampleByImportance(importance, 2500, 7, 8);
  ASSERT_EQ(drawn.size(), 2500u);
  EXPECT_TRUE(std::is_sorted(drawn.begin(), drawn.end()));
  EXPECT_EQ(std::adjacent_find(drawn.begin(), drawn.end()), drawn.end());
  EXPECT_EQ(drawn, SampleByImportance(importance, 2500, 7, 8));
  EXPECT_NE(drawn, SampleByImportance(importance, 2500, 8, 8));
  EXPECT_NE(drawn, SampleByImportance(importance, 2500, 7, 9));
  // A larger draw contains the smaller one: the keys do not change.
  const Indices more = SampleByImportance(importance, 3000, 7, 8);
  EXPECT_TRUE(
      std::includes(more.begin(), more.end(), drawn.begin(), drawn.end()));
  // Only their proportions matter.
  for (float& value : importance) value *= 0x1p-100f;
  EXPECT_EQ(drawn, SampleByImportance(importance, 2500, 7, 8));
}

TEST(SampleByImportanceTest, WithoutImportanceNeverDrawn) {
  const std::vector<float> importance = {
      0, kNotANumber, 1, -1, 1e-45f, kInfinity, -kInfinity, -0.0f, 1e38f};
  EXPECT_EQ(SampleByImportance(importance, 9, 1, 1), (Indices{2, 4, 8}));
  EXPECT_EQ(SampleByImportance(importance, 3, 1, 1), (Indices{2, 4, 8}));
  EXPECT_EQ(SampleByImportance(importance, 1, 1, 1), (Indices{8}));
  EXPECT_TRUE(SampleByImportance(importance, 0, 1, 1).empty());
  EXPECT_TRUE(SampleByImportance({}, 5, 1, 1).empty());
  EXPECT_TRUE(SampleByImportance(std::vector<float>{0, 0}, 1, 1, 1).empty());
  EXPECT_EQ(SampleByImportance(std::vector<float>{2}, 1, 1, 1), (Indices{0}));
}

TEST(KeepCumulativeImportanceTest, TheFewestThatCarryTheShare) {
  const std::vector<float> importance = {
      4, 0, 16, 4, 8, kNotANumber, -9, kInfinity};
  EXPECT_EQ(KeepCumulativeImportance(importance, 0.5), (Indices{2}));
  EXPECT_EQ(KeepCumulativeImportance(importance, 0.51), (Indices{2, 4}));
  EXPECT_EQ(KeepCumulativeImportance(importance, 0.75), (Indices{2, 4}));
  EXPECT_EQ(KeepCumulativeImportance(importance, 0.8), (Indices{0, 2, 4}));
  EXPECT_EQ(KeepCumulativeImportance(importance, 0.9), (Indices{0, 2, 3, 4}));
  EXPECT_EQ(KeepCumulativeImportance(importance, 1.0), (Indices{0, 2, 3, 4}));
  EXPECT_EQ(KeepCumulativeImportance(importance, 2.0), (Indices{0, 2, 3, 4}));
  EXPECT_TRUE(KeepCumulativeImportance(importance, 0.0).empty());
  EXPECT_TRUE(KeepCumulativeImportance({}, 0.9).empty());
  EXPECT_TRUE(KeepCumulativeImportance(std::vector<float>{0, 0}, 0.9).empty());
  EXPECT_EQ(KeepCumulativeImportance(std::vector<float>{3}, 0.01),
            (Indices{0}));
  // What rounding swallows is kept when all are asked for.
  EXPECT_EQ(KeepCumulativeImportance(std::vector<float>{1e-30f, 1}, 1.0),
            (Indices{0, 1}));
}

TEST(MostImportantTest, TheLargestTiesByIndex) {
  const std::vector<float> importance = {
      4, 0, 16, 4, 8, kNotANumber, -9, kInfinity};
  EXPECT_TRUE(MostImportant(importance, 0).empty());
  EXPECT_EQ(MostImportant(importance, 1), (Indices{2}));
  EXPECT_EQ(MostImportant(importance, 2), (Indices{2, 4}));
  EXPECT_EQ(MostImportant(importance, 3), (Indices{0, 2, 4}));
  EXPECT_EQ(MostImportant(importance, 4), (Indices{0, 2, 3, 4}));
  EXPECT_EQ(MostImportant(importance, 99), (Indices{0, 2, 3, 4}));
  EXPECT_TRUE(MostImportant({}, 3).empty());
  EXPECT_TRUE(MostImportant(std::vector<float>{0, kNotANumber}, 3).empty());
}

}  // namespace
}  // namespace freegs::splat
