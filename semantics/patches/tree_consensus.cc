// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/tree_consensus.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "core/random.h"

namespace freegs::semantics {
namespace {

constexpr uint64_t kNoiseSeed = 0x636f6e73656e;

// Regions of a tree that touch others, as a graph of their own.
struct Blocks {
  RegionGraph graph;
  std::vector<int32_t> region;  // In the tree, of each block.
};

Blocks TouchingBlocks(const RegionGraph& graph,
                      const std::vector<int32_t>& region_of_leaf) {
  std::map<std::pair<int32_t, int32_t>, ContactStats> contacts;
  for (const Contact& contact : graph.contacts) {
    const auto [a, b] =
        std::minmax(region_of_leaf[contact.a], region_of_leaf[contact.b]);
    if (a != b) contacts[{a, b}].Add(contact.stats);
  }
  Blocks blocks;
  blocks.graph.total_pixels = graph.total_pixels;
  std::map<int32_t, int32_t> block_of_region;
  for (const auto& [pair, stats] : contacts) {
    block_of_region[pair.first] = block_of_region[pair.second] = 0;
  }
  for (auto& [region, block] : block_of_region) {
    block = static_cast<int32_t>(blocks.region.size());
    blocks.region.push_back(region);
  }
  blocks.graph.regions.resize(blocks.region.size());
  for (size_t leaf = 0; leaf < region_of_leaf.size(); ++leaf) {
    const auto at = block_of_region.find(region_of_leaf[leaf]);
    if (at == block_of_region.end()) continue;
    blocks.graph.regions[at->second].Add(graph.regions[leaf]);
  }
  for (const Contact& contact : graph.contacts) {
    const int32_t region = region_of_leaf[contact.a];
    if (region != region_of_leaf[contact.b]) continue;
    const auto at = block_of_region.find(region);
    if (at == block_of_region.end()) continue;
    blocks.graph.regions[at->second].perimeter -=
        2 * (contact.stats.pixels + contact.stats.hidden);
  }
  for (const auto& [pair, stats] : contacts) {
    blocks.graph.contacts.push_back({block_of_region.at(pair.first),
                                     block_of_region.at(pair.second),
                                     stats});
  }
  return blocks;
}

// Takes back all merges above -sure, unless that leaves too many blocks.
Blocks CutBack(const RegionGraph& graph,
               const ConsensusOptions& options,
               RegionTree* tree) {
  constexpr double kAll = std::numeric_limits<double>::infinity();
  const std::vector<RegionTree::Merge> merges = std::move(tree->merges);
  const auto first_unsure = std::find_if(
      merges.begin(), merges.end(), [&](const RegionTree::Merge& merge) {
        return merge.height > -options.sure;
      });
  auto kept = static_cast<size_t>(first_unsure - merges.begin());
  for (;;) {
    tree->merges.assign(merges.begin(), merges.begin() + kept);
    Blocks blocks = TouchingBlocks(graph, tree->Cut(kAll));
    const size_t count = blocks.region.size();
    if (count <= options.max_blocks) return blocks;
    kept = std::min(merges.size(), kept + count - options.max_blocks);
  }
}

// A symmetric matrix, rows x rows.
class Matrix {
 public:
  explicit Matrix(size_t rows) : rows_(rows), values_(rows * rows, 0.0f) {}

  size_t rows() const { return rows_; }
  float operator()(size_t i, size_t j) const { return values_[i * rows_ + j]; }
  void Set(size_t i, size_t j, float value) {
    values_[i * rows_ + j] = values_[j * rows_ + i] = value;
  }

 private:
  size_t rows_;
  std::vector<float> values_;
};

// Adds the height at which a tree joins each pair of leaves.
void AddHeights(const RegionTree& tree, double sure, Matrix* sums) {
  std::vector<std::vector<int32_t>> leaves(tree.num_leaves +
                                           tree.merges.size());
  const auto add = [sums](const std::vector<int32_t>& some,
                          const std::vector<int32_t>& others,
                          double height) {
    for (const int32_t i : some) {
      for (const int32_t j : others) {
        sums->Set(i, j, (*sums)(i, j) + static_cast<float>(height));
      }
    }
  };
  for (int32_t leaf = 0; leaf < tree.num_leaves; ++leaf) leaves[leaf] = {leaf};
  for (size_t k = 0; k < tree.merges.size(); ++k) {
    const RegionTree::Merge& merge = tree.merges[k];
    std::vector<int32_t> joined = std::move(leaves[merge.a]);
    const std::vector<int32_t> other = std::move(leaves[merge.b]);
    add(joined, other, std::clamp(merge.height, -sure, sure));
    joined.insert(joined.end(), other.begin(), other.end());
    leaves[tree.num_leaves + k] = std::move(joined);
    leaves[merge.a].clear();
    leaves[merge.b].clear();
  }
  // What is never joined is surely apart.
  std::vector<int32_t> before;
  for (const std::vector<int32_t>& top : leaves) {
    add(before, top, sure);
    before.insert(before.end(), top.begin(), top.end());
  }
}

// Joins rows of a matrix of distances below a limit, the nearest first; a
// joined row is the weighted mean of the two.
class AverageLinkage {
 public:
  AverageLinkage(Matrix distances, std::vector<double> weights)
      : distances_(std::move(distances)),
        weights_(std::move(weights)),
        alive_(distances_.rows(), true),
        nearest_(distances_.rows()) {
    for (size_t i = 0; i < alive_.size(); ++i) FindNearest(i);
  }

  struct Pair {
    size_t kept = 0;  // Stands for both from now on.
    size_t gone = 0;
    double distance = 0;
  };

  // Returns false if there is none.
  bool Next(double limit, Pair* pair) {
    size_t best = kNone;
    for (size_t i = 0; i < alive_.size(); ++i) {
      if (alive_[i] && nearest_[i] != kNone &&
          (best == kNone ||
           distances_(i, nearest_[i]) < distances_(best, nearest_[best]))) {
        best = i;
      }
    }
    if (best == kNone) return false;
    *pair = {best, nearest_[best], distances_(best, nearest_[best])};
    if (!(pair->distance < limit)) return false;
    Join(pair->kept, pair->gone);
    return true;
  }

 private:
  static constexpr size_t kNone = std::numeric_limits<size_t>::max();

  void FindNearest(size_t i) {
    nearest_[i] = kNone;
    for (size_t j = 0; j < alive_.size(); ++j) {
      if (j == i || !alive_[j]) continue;
      if (nearest_[i] == kNone ||
          distances_(i, j) < distances_(i, nearest_[i])) {
        nearest_[i] = j;
      }
    }
  }

  void Join(size_t kept, size_t gone) {
    alive_[gone] = false;
    const double share = weights_[kept] / (weights_[kept] + weights_[gone]);
    weights_[kept] += weights_[gone];
    for (size_t j = 0; j < alive_.size(); ++j) {
      if (!alive_[j] || j == kept) continue;
      distances_.Set(kept,
                     j,
                     static_cast<float>(share * distances_(kept, j) +
                                        (1 - share) * distances_(gone, j)));
    }
    for (size_t j = 0; j < alive_.size(); ++j) {
      if (alive_[j] &&
          (j == kept || nearest_[j] == kept || nearest_[j] == gone)) {
        FindNearest(j);
      }
    }
  }

  Matrix distances_;
  std::vector<double> weights_;
  std::vector<bool> alive_;
  std::vector<size_t> nearest_;  // kNone for the last one.
};

}  // namespace

Status ConsensusOptions::Check() const {
  if (num_trees < 1 || !(noise >= 0) || !std::isfinite(lean) || !(sure > 0) ||
      max_blocks < 1) {
    return InvalidArgumentError(
        "a consensus needs trees, noise, sure heights and blocks");
  }
  return Status();
}

StatusOr<RegionTree> MergeByConsensus(const RegionGraph& graph,
                                      const DifferenceFn& difference,
                                      const ConsensusOptions& options,
                                      ThreadPool& pool) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  RegionTree result = MergeRegions(graph, difference);
  Blocks blocks = CutBack(graph, options, &result);
  std::vector<RegionTree> trees(options.num_trees);
  pool.ParallelFor(
      0, options.num_trees, 1, [&](int64_t first, int64_t last, int) {
        for (int64_t t = first; t < last; ++t) {
          uint64_t drawn = 0;
          trees[t] = MergeRegions(blocks.graph, [&](const Evidence& evidence) {
            return difference(evidence) +
                   options.noise * RandomNormal(kNoiseSeed, t, drawn++);
          });
        }
      });
  Matrix heights(blocks.region.size());
  for (const RegionTree& tree : trees) {
    AddHeights(tree, options.sure, &heights);
  }
  std::vector<double> pixels;
  for (const RegionStats& region : blocks.graph.regions) {
    pixels.push_back(region.pixels + 1);
  }
  AverageLinkage linkage(std::move(heights), std::move(pixels));
  // What no tree joins has the height `sure` in all of them.
  const double limit = 0.999 * options.sure * options.num_trees;
  AverageLinkage::Pair pair;
  double height = result.merges.empty() ? -options.sure + options.lean
                                        : result.merges.back().height;
  while (linkage.Next(limit, &pair)) {
    height = std::max(height, pair.distance / options.num_trees + options.lean);
    result.merges.push_back(
        {blocks.region[pair.kept], blocks.region[pair.gone], height});
    blocks.region[pair.kept] =
        result.num_leaves + static_cast<int32_t>(result.merges.size()) - 1;
  }
  return result;
}

}  // namespace freegs::semantics
