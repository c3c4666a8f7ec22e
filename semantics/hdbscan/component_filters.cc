// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/hdbscan/component_filters.h"

#include <algorithm>

namespace freegs::semantics {

ComponentFilters::ComponentFilters(const KdTree& tree,
                                   std::span<const double> core2)
    : tree_(tree) {
  components_.resize(tree.num_levels());
  floors_.resize(tree.num_levels());
  floors_[0].resize(RoundUp(tree.size()), 0.0f);
  std::transform(core2.begin(), core2.end(), floors_[0].begin(), KdFloor);
  for (int level = 1; level < tree.num_levels(); ++level) {
    const uint32_t num_nodes = tree.num_nodes(level - 1);
    components_[level].resize(RoundUp(num_nodes), kMixed);
    floors_[level].resize(RoundUp(num_nodes), 0.0f);
    for (uint32_t node = 0; node < num_nodes; ++node) {
      const auto first = floors_[level - 1].begin() + node * KdTree::kFanout;
      floors_[level][node] =
          *std::min_element(first, first + NumChildren(level - 1, node));
    }
  }
}

void ComponentFilters::Update(const std::vector<uint32_t>& components) {
  points_ = components.data();
  for (int level = 1; level < tree_.num_levels(); ++level) {
    const uint32_t* below =
        level == 1 ? points_ : components_[level - 1].data();
    for (uint32_t node = 0; node < tree_.num_nodes(level - 1); ++node) {
      const uint32_t* first =
          below + static_cast<size_t>(node) * KdTree::kFanout;
      const uint32_t* last = first + NumChildren(level - 1, node);
      const bool common =
          std::all_of(first, last, [&](uint32_t c) { return c == *first; });
      components_[level][node] = common ? *first : kMixed;
    }
  }
}

int ComponentFilters::NumChildren(int level, uint32_t node) const {
  const size_t below = level == 0 ? tree_.size() : tree_.num_nodes(level - 1);
  return static_cast<int>(std::min<size_t>(
      KdTree::kFanout, below - static_cast<size_t>(node) * KdTree::kFanout));
}

}  // namespace freegs::semantics
