// SPDX-License-Identifier: BSD-3-Clause
// What a search for the nearest point of another component may skip in a k-d
// tree.

#ifndef FREEGS_SEMANTICS_HDBSCAN_COMPONENT_FILTERS_H_
#define FREEGS_SEMANTICS_HDBSCAN_COMPONENT_FILTERS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/kd_tree.h"

namespace freegs::semantics {

// For the children of each node, or the points of each leaf: the component that
// holds them all, and the least squared core distance among them.
class ComponentFilters {
 public:
  static constexpr uint32_t kMixed = 0xffffffffu;

  // core2: squared core distances by tree position. The tree must outlive this
  // object and not be empty. Components are unknown before Update().
  ComponentFilters(const KdTree& tree, std::span<const double> core2);

  // components: by tree position, padded to whole leaves; must outlive its use
  // by At().
  void Update(const std::vector<uint32_t>& components);

  // For a search from component `own`.
  KdBlockFilter At(int level, uint32_t node, uint32_t own) const {
    const size_t first = static_cast<size_t>(node) * KdTree::kFanout;
    return {.components =
                (level == 0 ? points_ : components_[level].data()) + first,
            .own = own,
            .floors = floors_[level].data() + first};
  }

  static size_t RoundUp(size_t count) {
    return (count + KdTree::kFanout - 1) / KdTree::kFanout * KdTree::kFanout;
  }

 private:
  int NumChildren(int level, uint32_t node) const;

  const KdTree& tree_;
  const uint32_t* points_ = nullptr;
  // By level and child of its nodes; floors are rounded down.
  std::vector<std::vector<uint32_t>> components_;
  std::vector<std::vector<float>> floors_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_HDBSCAN_COMPONENT_FILTERS_H_
