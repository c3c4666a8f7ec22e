// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/region_joining.h"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::semantics {
namespace {

using Leaves = std::set<int32_t>;

std::vector<Leaves> LeavesOf(const RegionTree& tree) {
  std::vector<Leaves> leaves;
  for (int32_t leaf = 0; leaf < tree.num_leaves; ++leaf) {
    leaves.push_back({leaf});
  }
  for (const RegionTree::Merge& merge : tree.merges) {
    Leaves both = leaves[merge.a];
    both.insert(leaves[merge.b].begin(), leaves[merge.b].end());
    leaves.push_back(std::move(both));
  }
  return leaves;
}

bool Overlap(const Leaves& a, const Leaves& b) {
  return std::any_of(
      a.begin(), a.end(), [&](int32_t leaf) { return b.contains(leaf); });
}

TEST(RegionJoiningTest, PutsARegionBesideAnother) {
  // 4 is {0, 1}, 5 is {4, 2}, 6 is {5, 3}.
  const RegionTree comb = {.num_leaves = 4,
                           .merges = {{0, 1, 1}, {4, 2, 2}, {5, 3, 3}}};
  const JoinedTree joined = JoinRegions(comb, 4, 3);
  EXPECT_EQ(joined.tree.merges,
            (std::vector<RegionTree::Merge>{{0, 1, 1}, {4, 3, 1}, {5, 2, 2}}));
  EXPECT_EQ(joined.joined, 5);
  EXPECT_EQ(joined.place, (std::vector<int32_t>{0, 1, 2, 3, 4, 6, 6}));
}

TEST(RegionJoiningTest, WhatIsTogetherStaysAsItIs) {
  const RegionTree tree = {.num_leaves = 3, .merges = {{0, 2, 1}, {3, 1, 2}}};
  const JoinedTree joined = JoinRegions(tree, 1, 3);
  EXPECT_EQ(joined.tree.merges, tree.merges);
  EXPECT_EQ(joined.joined, 4);
  EXPECT_EQ(joined.place, (std::vector<int32_t>{0, 1, 2, 3, 4}));
}

TEST(RegionJoiningTest, TreesThatNeverMet) {
  const RegionTree tree = {.num_leaves = 4, .merges = {{0, 1, 5}}};
  const JoinedTree joined = JoinRegions(tree, 2, 4);
  EXPECT_EQ(joined.tree.merges,
            (std::vector<RegionTree::Merge>{{0, 1, 5}, {2, 4, 5}}));
  EXPECT_EQ(joined.joined, 5);
}

TEST(RegionJoiningTest, RandomTreesKeepAllOtherRegions) {
  constexpr uint64_t kStream = 7;
  uint64_t drawn = 0;
  const auto below = [&](size_t count) {
    return static_cast<size_t>(RandomUniform(3, kStream, drawn++) *
                               static_cast<double>(count));
  };
  for (int round = 0; round < 200; ++round) {
    RegionTree tree;
    tree.num_leaves = 2 + static_cast<int>(below(12));
    std::vector<int32_t> roots;
    for (int32_t leaf = 0; leaf < tree.num_leaves; ++leaf) {
      roots.push_back(leaf);
    }
    const size_t last = 1 + below(3);
    double height = -2;
    while (roots.size() > last) {
      std::swap(roots[below(roots.size())], roots.back());
      const int32_t a = roots.back();
      roots.pop_back();
      int32_t& b = roots[below(roots.size())];
      height += below(2) == 0 ? 0 : 0.5;
      tree.merges.push_back({a, b, height});
      b = tree.num_leaves + static_cast<int32_t>(tree.merges.size()) - 1;
    }
    const std::vector<Leaves> before = LeavesOf(tree);
    const auto a = static_cast<int32_t>(below(before.size()));
    const auto b = static_cast<int32_t>(below(before.size()));
    if (Overlap(before[a], before[b])) continue;
    const JoinedTree joined = JoinRegions(tree, a, b);
    const std::vector<Leaves> after = LeavesOf(joined.tree);
    Leaves both = before[a];
    both.insert(before[b].begin(), before[b].end());
    EXPECT_EQ(after[joined.joined], both);
    Leaves parts;
    for (size_t k = 0; k < joined.tree.merges.size(); ++k) {
      const RegionTree::Merge& merge = joined.tree.merges[k];
      EXPECT_TRUE(parts.insert(merge.a).second);
      EXPECT_TRUE(parts.insert(merge.b).second);
      EXPECT_LT(std::max(merge.a, merge.b),
                joined.tree.num_leaves + static_cast<int32_t>(k));
      if (k > 0) {
        EXPECT_GE(merge.height, joined.tree.merges[k - 1].height);
      }
    }
    for (size_t r = 0; r < before.size(); ++r) {
      const bool within_one = std::includes(before[a].begin(),
                                            before[a].end(),
                                            before[r].begin(),
                                            before[r].end()) ||
                              std::includes(before[b].begin(),
                                            before[b].end(),
                                            before[r].begin(),
                                            before[r].end());
      const bool has_none = !Overlap(before[r], both);
      const bool has_both = std::includes(
          before[r].begin(), before[r].end(), both.begin(), both.end());
      if (within_one || has_none || has_both) {
        const int32_t place = joined.place[r];
        // A region of `b` and another one may be gone, which then has no part
        // in the two.
        if (place >= 0) {
          EXPECT_EQ(after[place], before[r]);
        } else {
          EXPECT_TRUE(has_none);
        }
      }
    }
  }
}

}  // namespace
}  // namespace freegs::semantics
