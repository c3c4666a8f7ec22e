// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/adjusted_rand_index.h"

#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::semantics {
namespace {

using Labels = std::vector<int32_t>;

TEST(AdjustedRandIndexTest, NamesDoNotMatter) {
  EXPECT_EQ(AdjustedRandIndex(Labels{0, 0, 1, 1, -1}, Labels{7, 7, 3, 3, 0}),
            1);
}

TEST(AdjustedRandIndexTest, ByHand) {
  // Contingency {{1, 1}, {1, 1}}: no pair together in both, 2 in each, of 6.
  EXPECT_NEAR(AdjustedRandIndex(Labels{0, 0, 1, 1}, Labels{0, 1, 0, 1}),
              (0 - 2.0 / 3) / (2 - 2.0 / 3),
              1e-12);
  // {{2, 1}, {0, 3}}: 1 + 3 pairs together; 6 and 1 + 6 in each, of 15.
  EXPECT_NEAR(
      AdjustedRandIndex(Labels{0, 0, 0, 1, 1, 1}, Labels{0, 0, 1, 1, 1, 1}),
      (4 - 42.0 / 15) / (6.5 - 42.0 / 15),
      1e-12);
}

TEST(AdjustedRandIndexTest, NegativeLabelsAreOneCluster) {
  EXPECT_EQ(AdjustedRandIndex(Labels{-1, -2, 4}, Labels{1, 1, 0}), 1);
}

TEST(AdjustedRandIndexTest, NothingToTellApartIsAgreement) {
  EXPECT_EQ(AdjustedRandIndex(Labels{}, Labels{}), 1);
  EXPECT_EQ(AdjustedRandIndex(Labels{5}, Labels{6}), 1);
  EXPECT_EQ(AdjustedRandIndex(Labels{1, 1, 1}, Labels{2, 2, 2}), 1);
  EXPECT_EQ(AdjustedRandIndex(Labels{1, 2, 3}, Labels{3, 2, 1}), 1);
}

TEST(AdjustedRandIndexTest, IndependentLabelsAreNearZero) {
  Labels a;
  Labels b;
  for (int i = 0; i < 20000; ++i) {
    a.push_back(static_cast<int32_t>(RandomIndex(1, 2, i, 5)));
    b.push_back(static_cast<int32_t>(RandomIndex(3, 4, i, 7)));
  }
  EXPECT_NEAR(AdjustedRandIndex(a, b), 0, 0.005);
}

}  // namespace
}  // namespace freegs::semantics
