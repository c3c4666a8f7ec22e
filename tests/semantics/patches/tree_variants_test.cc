// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/tree_variants.h"

#include <cstdint>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::semantics {
namespace {

TEST(TreeVariantsTest, WeightsChangeWithinTheirBounds) {
  EvidenceModel model;
  for (size_t k = 0; k < model.weight.size(); ++k) {
    model.weight[k] = k % 2 == 0 ? 1.5 : -2.0;
  }
  model.bias = 3;
  EXPECT_EQ(VariantOf(model, 0).weight, model.weight);
  std::set<double> first_weights;
  for (int v = 1; v < kNumTreeVariants; ++v) {
    const EvidenceModel changed = VariantOf(model, v);
    EXPECT_EQ(changed.bias, model.bias);
    EXPECT_EQ(changed.weight, VariantOf(model, v).weight);
    for (size_t k = 0; k < model.weight.size(); ++k) {
      const double factor = changed.weight[k] / model.weight[k];
      EXPECT_GE(factor, 0.3);
      EXPECT_LE(factor, 1.7);
    }
    first_weights.insert(changed.weight[0]);
  }
  EXPECT_EQ(first_weights.size(), static_cast<size_t>(kNumTreeVariants - 1));
}

// The same leaves in both trees.
std::vector<SharedPixels> SameLeaves(const std::vector<double>& sizes) {
  std::vector<SharedPixels> shared;
  for (size_t leaf = 0; leaf < sizes.size(); ++leaf) {
    const auto own = static_cast<int32_t>(leaf);
    shared.push_back({own, own, sizes[leaf]});
  }
  return shared;
}

// The regions with at least min_size.
std::vector<uint8_t> Large(const RegionTree& tree,
                           const std::vector<double>& sizes,
                           double min_size) {
  std::vector<uint8_t> large;
  for (const double size : tree.Sums(sizes)) large.push_back(size >= min_size);
  return large;
}

TEST(TreeVariantsTest, TakesTheRegionThatIsMostAlike) {
  // {0, 1}, {2, 3} and all; the other tree has {1, 2} and {1, 2, 3}.
  const RegionTree tree = {.num_leaves = 4,
                           .merges = {{0, 1, 0}, {2, 3, 1}, {4, 5, 2}}};
  const RegionTree other = {.num_leaves = 4,
                            .merges = {{1, 2, 0}, {4, 3, 1}, {5, 0, 2}}};
  const std::vector<double> sizes = {1, 3, 2, 2};
  const std::vector<double> quality = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7};
  const std::vector<double> result = QualityInOther(tree,
                                                    Large(tree, sizes, 2),
                                                    other,
                                                    Large(other, sizes, 2),
                                                    quality,
                                                    SameLeaves(sizes));
  ASSERT_EQ(result.size(), 7u);
  EXPECT_EQ(result[0], 0);  // Too small.
  EXPECT_DOUBLE_EQ(result[1], 0.2);
  EXPECT_DOUBLE_EQ(result[2], 0.3);
  // {0, 1} is most like leaf 1, {2, 3} like {1, 2, 3}.
  EXPECT_DOUBLE_EQ(result[4], 3.0 / 4 * 0.2);
  EXPECT_DOUBLE_EQ(result[5], 4.0 / 7 * 0.6);
  EXPECT_DOUBLE_EQ(result[6], 0.7);
}

RegionTree RandomTree(int num_leaves, size_t num_merges, uint64_t seed) {
  RegionTree tree;
  tree.num_leaves = num_leaves;
  std::vector<int32_t> roots;
  for (int32_t r = 0; r < num_leaves; ++r) roots.push_back(r);
  for (size_t k = 0; k < num_merges; ++k) {
    const auto take = [&](uint64_t stream) {
      const auto i = static_cast<std::ptrdiff_t>(
          RandomIndex(seed, stream, k, roots.size()));
      const int32_t root = roots[i];
      roots.erase(roots.begin() + i);
      return root;
    };
    const int32_t a = take(0);
    const int32_t b = take(1);
    tree.merges.push_back({a, b, static_cast<double>(k)});
    roots.push_back(num_leaves + static_cast<int32_t>(k));
  }
  return tree;
}

// The leaves of each region.
std::vector<std::set<int32_t>> LeavesOf(const RegionTree& tree) {
  std::vector<std::set<int32_t>> leaves;
  for (int32_t r = 0; r < tree.num_leaves; ++r) leaves.push_back({r});
  for (const RegionTree::Merge& merge : tree.merges) {
    std::set<int32_t> both = leaves[merge.a];
    both.insert(leaves[merge.b].begin(), leaves[merge.b].end());
    leaves.push_back(std::move(both));
  }
  return leaves;
}

// Trees that fall into several parts, compared with sets of pieces. The second
// tree is of another division: its leaves are pairs of those of the first, and
// each piece of a leaf counts for both.
TEST(TreeVariantsTest, EqualsComparingSets) {
  constexpr int kLeaves = 30;
  constexpr int kOtherLeaves = 20;
  for (uint64_t seed = 0; seed < 6; ++seed) {
    std::vector<SharedPixels> pieces;
    std::vector<double> sizes(kLeaves, 0.0);
    std::vector<double> other_sizes(kOtherLeaves, 0.0);
    for (int32_t a = 0; a < kLeaves; ++a) {
      for (int32_t b = 0; b < kOtherLeaves; ++b) {
        const auto k = static_cast<uint64_t>(a * kOtherLeaves + b);
        if (RandomUniform(1, seed, k) > 0.1) continue;
        pieces.push_back({a, b, 1 + RandomUniform(2, seed, k)});
        sizes[a] += pieces.back().pixels;
        other_sizes[b] += pieces.back().pixels;
      }
    }
    const RegionTree tree = RandomTree(kLeaves, 27, seed);
    const RegionTree other = RandomTree(kOtherLeaves, 16, 100 + seed);
    const auto of_tree = LeavesOf(tree);
    const auto of_other = LeavesOf(other);
    std::vector<double> quality;
    for (size_t x = 0; x < of_other.size(); ++x) {
      quality.push_back(RandomUniform(3, seed, x));
    }
    // Every other time regions of a few leaves are small.
    const double min_size = seed % 2 == 0 ? 0 : 6;
    const std::vector<uint8_t> large = Large(tree, sizes, min_size);
    const std::vector<uint8_t> other_large =
        Large(other, other_sizes, min_size);
    const std::vector<double> result =
        QualityInOther(tree, large, other, other_large, quality, pieces);
    for (size_t r = 0; r < of_tree.size(); ++r) {
      double best = 0;
      double expected = 0;
      for (size_t x = 0; x < of_other.size(); ++x) {
        if (large[r] == 0 || other_large[x] == 0) continue;
        double both = 0;
        double either = 0;
        for (const SharedPixels& piece : pieces) {
          const bool in_a = of_tree[r].contains(piece.a);
          const bool in_b = of_other[x].contains(piece.b);
          if (in_a && in_b) both += piece.pixels;
          if (in_a || in_b) either += piece.pixels;
        }
        if (both > 0 && both / either > best + 1e-12) {
          best = both / either;
          expected = best * quality[x];
        }
      }
      EXPECT_NEAR(result[r], expected, 1e-9) << r;
    }
  }
}

}  // namespace
}  // namespace freegs::semantics
