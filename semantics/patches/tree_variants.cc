// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/tree_variants.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/random.h"

namespace freegs::semantics {
namespace {

// Weights are multiplied by 1 - kMostChange to 1 + kMostChange.
constexpr double kMostChange = 0.7;
constexpr uint64_t kWeightSeed = 77;  // Seed of these factors.

// The leaves in an order in which those of each region are neighbours: region r
// has order[first[r]] to order[first[r] + count[r] - 1].
struct LeafOrder {
  std::vector<int32_t> order;
  std::vector<int32_t> first;
  std::vector<int32_t> count;
};

LeafOrder OrderLeaves(const RegionTree& tree) {
  const auto num_leaves = static_cast<int32_t>(tree.num_leaves);
  const auto num_regions =
      num_leaves + static_cast<int32_t>(tree.merges.size());
  LeafOrder leaves;
  leaves.count.assign(num_regions, 1);
  for (int32_t r = num_leaves; r < num_regions; ++r) {
    const RegionTree::Merge& merge = tree.merges[r - num_leaves];
    leaves.count[r] = leaves.count[merge.a] + leaves.count[merge.b];
  }
  // From the roots down: the parts of a region share its places.
  leaves.first.assign(num_regions, -1);
  leaves.order.resize(num_leaves);
  int32_t next = 0;
  for (int32_t r = num_regions; r-- > 0;) {
    if (leaves.first[r] < 0) {
      leaves.first[r] = next;
      next += leaves.count[r];
    }
    if (r < num_leaves) {
      leaves.order[leaves.first[r]] = r;
      continue;
    }
    const RegionTree::Merge& merge = tree.merges[r - num_leaves];
    leaves.first[merge.a] = leaves.first[r];
    leaves.first[merge.b] = leaves.first[r] + leaves.count[merge.a];
  }
  return leaves;
}

// The large regions of a tree, in its order.
struct LargeRegions {
  std::vector<int32_t> region;
  std::vector<int32_t> parent;   // A place in `region`; -1 for a root.
  std::vector<int32_t> of_leaf;  // The smallest that has it; -1 for none.
};

LargeRegions FindLargeRegions(const RegionTree& tree,
                              std::span<const uint8_t> is_large) {
  LargeRegions large;
  std::vector<int32_t> place(is_large.size(), -1);
  for (size_t r = 0; r < is_large.size(); ++r) {
    if (is_large[r] == 0) continue;
    place[r] = static_cast<int32_t>(large.region.size());
    large.region.push_back(static_cast<int32_t>(r));
  }
  large.parent.assign(large.region.size(), -1);
  // From the roots down, so that small regions find what is above them.
  for (size_t k = tree.merges.size(); k-- > 0;) {
    const int32_t own = place[tree.num_leaves + k];
    for (const int32_t part : {tree.merges[k].a, tree.merges[k].b}) {
      if (place[part] >= 0) {
        large.parent[place[part]] = own;
      } else {
        place[part] = own;
      }
    }
  }
  large.of_leaf.assign(place.begin(), place.begin() + tree.num_leaves);
  return large;
}

}  // namespace

EvidenceModel VariantOf(const EvidenceModel& model, int variant) {
  EvidenceModel changed = model;
  if (variant == 0) return changed;
  for (size_t k = 0; k < changed.weight.size(); ++k) {
    const double u =
        RandomUniform(kWeightSeed, static_cast<uint64_t>(variant - 1), k);
    changed.weight[k] *= 1 + kMostChange * (2 * u - 1);
  }
  return changed;
}

std::vector<double> QualityInOther(const RegionTree& tree,
                                   std::span<const uint8_t> is_large,
                                   const RegionTree& other,
                                   std::span<const uint8_t> other_is_large,
                                   std::span<const double> other_quality,
                                   std::span<const SharedPixels> shared) {
  const PatchPixels pixels =
      PixelsOfPatches(shared, tree.num_leaves, other.num_leaves);
  const std::vector<double> sizes = tree.Sums(pixels.of_a);
  const std::vector<double> other_sizes = other.Sums(pixels.of_b);
  const LeafOrder leaves = OrderLeaves(tree);
  const LargeRegions large = FindLargeRegions(other, other_is_large);
  std::vector<double> result(sizes.size(), 0.0);
  std::vector<double> common(large.region.size());
  for (size_t r = 0; r < sizes.size(); ++r) {
    if (is_large[r] == 0) continue;
    std::fill(common.begin(), common.end(), 0.0);
    for (int32_t i = 0; i < leaves.count[r]; ++i) {
      const int32_t leaf = leaves.order[leaves.first[r] + i];
      for (size_t k = pixels.first_of_a[leaf]; k < pixels.first_of_a[leaf + 1];
           ++k) {
        const int32_t place = large.of_leaf[shared[k].b];
        if (place >= 0) common[place] += shared[k].pixels;
      }
    }
    double best_iou = 0;
    for (size_t x = 0; x < common.size(); ++x) {
      if (!(common[x] > 0)) continue;
      if (large.parent[x] >= 0) common[large.parent[x]] += common[x];
      const int32_t region = large.region[x];
      const double iou =
          common[x] / (sizes[r] + other_sizes[region] - common[x]);
      if (iou > best_iou) {
        best_iou = iou;
        result[r] = iou * other_quality[region];
      }
    }
  }
  return result;
}

}  // namespace freegs::semantics
