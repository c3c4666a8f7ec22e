// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/relevancy.h"

#include <cmath>

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

TEST(RelevancyTest, TheStrongestRivalDecides) {
  const std::vector<float> text = {1, 0, 0};
  const std::vector<float> canonical = {0, 1, 0, 0, 0, 1};
  const float expected =
      static_cast<float>(1 / (1 + std::exp(10 * (0.6 - 0.8))));
  // The feature's length does not matter.
  EXPECT_NEAR(
      Relevancy(std::vector<float>{8, 6, 0}, text, canonical), expected, 1e-6);
  EXPECT_NEAR(Relevancy(std::vector<float>{0.08f, 0.06f, 0}, text, canonical),
              expected,
              1e-6);
  EXPECT_NEAR(Relevancy(text, text, canonical), 1 / (1 + std::exp(-10)), 1e-6);
  EXPECT_LT(Relevancy(std::vector<float>{0, 0, 2}, text, canonical), 1e-4);
}

TEST(RelevancyTest, NothingToCompare) {
  const std::vector<float> text = {1, 0};
  EXPECT_FLOAT_EQ(Relevancy(std::vector<float>{0, 0}, text, text), 0.5f);
  EXPECT_FLOAT_EQ(Relevancy(text, text, {}), 1);
  EXPECT_FLOAT_EQ(Relevancy({}, {}, {}), 1);
}

}  // namespace
}  // namespace freegs::semantics
