// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/metrics/adjusted_rand_index.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::semantics {
namespace {

double Ari(const std::vector<int32_t>& a, const std::vector<int32_t>& b) {
  const auto index = AdjustedRandIndex(a, b);
  return index.ok() ? *index : std::nan("");
}

TEST(AdjustedRandIndexTest, NamesDoNotMatter) {
  EXPECT_EQ(Ari({0, 0, 1, 1, -1}, {7, 7, -1, -1, 3}), 1);
  EXPECT_EQ(Ari({2147483647, 5}, {-2147483647 - 1, 6}), 1);
}

TEST(AdjustedRandIndexTest, ByHand) {
  // Cells 2 1 / 0 3: pairs in both 1 + 3 = 4, in a 3 + 3 = 6, in b 1 + 6 = 7,
  // of 15. Expected 6 * 7 / 15 = 2.8, largest 6.5: 1.2 / 3.7.
  EXPECT_NEAR(Ari({0, 0, 0, 1, 1, 1}, {0, 0, 1, 1, 1, 1}), 1.2 / 3.7, 1e-15);
  // Cells 1 1 / 1 1: none in both, 2 in each, of 6. Expected 2 / 3, largest 2.
  EXPECT_NEAR(Ari({0, 0, 1, 1}, {0, 1, 0, 1}), -0.5, 1e-15);
  // Cells 2 0 / 1 1: 1 in both, 2 in a, 3 in b, of 6. Expected 1.
  EXPECT_NEAR(Ari({0, 0, 1, 1}, {0, 0, 0, 1}), 0, 1e-15);
  // All together against all apart: no pair in both, and none expected.
  EXPECT_EQ(Ari({0, 0, 0}, {0, 1, 2}), 0);
}

TEST(AdjustedRandIndexTest, TrivialPartitionsAgree) {
  EXPECT_EQ(Ari({}, {}), 1);
  EXPECT_EQ(Ari({3}, {4}), 1);
  EXPECT_EQ(Ari({1, 1, 1}, {0, 0, 0}), 1);
  EXPECT_EQ(Ari({0, 1, 2}, {5, 4, 3}), 1);
}

TEST(AdjustedRandIndexTest, SymmetricAndNearZeroByChance) {
  std::vector<int32_t> a(20000);
  std::vector<int32_t> b(20000);
  for (size_t i = 0; i < a.size(); ++i) {
    a[i] = static_cast<int32_t>(RandomIndex(1, 0, i, 12));
    b[i] = static_cast<int32_t>(RandomIndex(1, 1, i, 7));
  }
  EXPECT_EQ(Ari(a, b), Ari(b, a));
  EXPECT_NEAR(Ari(a, b), 0, 0.002);
}

TEST(AdjustedRandIndexTest, RefusesDifferentSizes) {
  const std::vector<int32_t> a = {0, 1};
  const std::vector<int32_t> b = {0, 1, 1};
  EXPECT_EQ(AdjustedRandIndex(a, b).status().code(),
            StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace freegs::semantics
