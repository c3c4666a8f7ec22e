// SPDX-License-Identifier: BSD-3-Clause

#include "core/disjoint_sets.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs {
namespace {

TEST(DisjointSetsTest, JoinsAndSaysWhetherItDid) {
  DisjointSets sets(5);
  EXPECT_EQ(sets.size(), 5u);
  EXPECT_TRUE(sets.Join(3, 4));
  EXPECT_TRUE(sets.Join(1, 4));
  EXPECT_FALSE(sets.Join(3, 1));
  EXPECT_EQ(sets.Find(4), 1u);
  EXPECT_EQ(sets.Find(0), 0u);
  EXPECT_EQ(sets.Find(2), 2u);
}

// Against labels that are rewritten with every connection.
TEST(DisjointSetsTest, SmallestMemberStandsForItsSet) {
  constexpr uint32_t kCount = 200;
  DisjointSets sets(kCount);
  std::vector<uint32_t> labels(kCount);
  std::iota(labels.begin(), labels.end(), 0u);
  for (uint64_t k = 0; k < 150; ++k) {
    const auto a = static_cast<uint32_t>(RandomIndex(1, 0, k, kCount));
    const auto b = static_cast<uint32_t>(RandomIndex(1, 1, k, kCount));
    const uint32_t smaller = std::min(labels[a], labels[b]);
    const uint32_t larger = std::max(labels[a], labels[b]);
    EXPECT_EQ(sets.Join(a, b), smaller != larger);
    for (uint32_t& label : labels) {
      if (label == larger) label = smaller;
    }
  }
  for (uint32_t i = 0; i < kCount; ++i) EXPECT_EQ(sets.Find(i), labels[i]);
}

}  // namespace
}  // namespace freegs
