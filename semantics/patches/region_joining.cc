// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/region_joining.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>

namespace freegs::semantics {
namespace {

// A tree whose regions can be put elsewhere.
class TreeEditor {
 public:
  explicit TreeEditor(const RegionTree& tree)
      : num_leaves_(tree.num_leaves),
        parent_(tree.num_leaves + tree.merges.size(), -1),
        parts_(parent_.size(), {-1, -1}),
        // Leaves were there before the first merge.
        height_(parent_.size(),
                tree.merges.empty() ? 0 : tree.merges.front().height) {
    for (size_t k = 0; k < tree.merges.size(); ++k) {
      const RegionTree::Merge& merge = tree.merges[k];
      const auto region = static_cast<int32_t>(num_leaves_ + k);
      parts_[region] = {merge.a, merge.b};
      height_[region] = merge.height;
      parent_[merge.a] = parent_[merge.b] = region;
    }
  }

  // Puts `b` beside `a`. Returns the region of both. A region that has only one
  // part left is gone; that part has all its leaves again if `a` is in it.
  int32_t Join(int32_t a, int32_t b) {
    if (parent_[a] >= 0 && parent_[a] == parent_[b]) return parent_[a];
    const int32_t old = parent_[b];
    if (old >= 0) {
      const int32_t other =
          parts_[old][0] == b ? parts_[old][1] : parts_[old][0];
      if (IsIn(a, other)) {
        gone_ = old;
        heir_ = other;
      }
      Replace(old, other);
      parts_[old] = {-1, -1};
    }
    const auto joined = static_cast<int32_t>(parent_.size());
    parent_.push_back(-1);
    parts_.push_back({-1, -1});
    height_.push_back(std::max(height_[a], height_[b]));
    Replace(a, joined);
    parts_[joined] = {a, b};
    parent_[a] = parent_[b] = joined;
    for (int32_t r = joined; parent_[r] >= 0; r = parent_[r]) {
      height_[parent_[r]] = std::max(height_[parent_[r]], height_[r]);
    }
    return joined;
  }

  // The tree, and the number that each region has there; -1 for none.
  RegionTree Finish(std::vector<int32_t>* number) const {
    // Parts come before what they make, also where heights are equal.
    const std::vector<int32_t> depth = Depths();
    std::vector<int32_t> order;
    for (size_t r = num_leaves_; r < parts_.size(); ++r) {
      if (parts_[r][0] >= 0) order.push_back(static_cast<int32_t>(r));
    }
    std::stable_sort(order.begin(), order.end(), [&](int32_t x, int32_t y) {
      if (height_[x] != height_[y]) return height_[x] < height_[y];
      return depth[x] > depth[y];
    });
    number->assign(parts_.size(), -1);
    std::iota(number->begin(), number->begin() + num_leaves_, 0);
    RegionTree tree;
    tree.num_leaves = num_leaves_;
    for (const int32_t r : order) {
      (*number)[r] = num_leaves_ + static_cast<int32_t>(tree.merges.size());
      tree.merges.push_back(
          {(*number)[parts_[r][0]], (*number)[parts_[r][1]], height_[r]});
    }
    if (gone_ >= 0) (*number)[gone_] = (*number)[heir_];
    return tree;
  }

 private:
  bool IsIn(int32_t region, int32_t other) const {
    while (region >= 0 && region != other) region = parent_[region];
    return region == other;
  }

  // Puts a region in the place of another one.
  void Replace(int32_t region, int32_t by) {
    const int32_t above = parent_[region];
    parent_[by] = above;
    if (above < 0) return;
    std::replace(parts_[above].begin(), parts_[above].end(), region, by);
  }

  // How many regions each one is in.
  std::vector<int32_t> Depths() const {
    std::vector<int32_t> depth(parts_.size(), -1);
    std::vector<int32_t> path;
    for (size_t r = 0; r < parts_.size(); ++r) {
      int32_t at = static_cast<int32_t>(r);
      for (; at >= 0 && depth[at] < 0; at = parent_[at]) path.push_back(at);
      int32_t above = at < 0 ? -1 : depth[at];
      for (; !path.empty(); path.pop_back()) depth[path.back()] = ++above;
    }
    return depth;
  }

  const int num_leaves_;
  std::vector<int32_t> parent_;
  std::vector<std::array<int32_t, 2>>
      parts_;  // -1 for leaves and what is gone.
  std::vector<double> height_;
  int32_t gone_ = -1;  // Its leaves are those of heir_ now.
  int32_t heir_ = -1;
};

}  // namespace

JoinedTree JoinRegions(const RegionTree& tree, int32_t a, int32_t b) {
  TreeEditor editor(tree);
  const int32_t joined = editor.Join(a, b);
  JoinedTree result;
  result.tree = editor.Finish(&result.place);
  result.joined = result.place[joined];
  result.place.resize(tree.num_leaves + tree.merges.size());
  return result;
}

}  // namespace freegs::semantics
