// SPDX-License-Identifier: BSD-3-Clause
// Tells a search for the nearest point of another component which parts of a
// k-d tree it may skip.

#ifndef FREEGS_SEMANTICS_HDBSCAN_COMPONENT_FILTERS_H_
#define FREEGS_SEMANTICS_HDBSCAN_COMPONENT_FILTERS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/kd_tree.h"

namespace freegs::semantics {

// Holds, for each child of each node and for each point of each leaf, the
// component that contains all of its points (kMixed if there are several), and
// a lower bound of their squared core distances.
class ComponentFilters {
 public:
  static constexpr uint32_t kMixed = 0xffffffffu;

  // core2: squared core distances by tree position. The tree must outlive this
  // object and have at least one point. Call Update() before At().
  ComponentFilters(const KdTree& tree, std::span<const double> core2);

  // components: by tree position, with RoundUp(size) entries. The vector must
  // outlive the calls of At(), which reads it.
  void Update(const std::vector<uint32_t>& components);

  // The filter of a node for a search that starts in component `own`.
  KdBlockFilter At(int level, uint32_t node, uint32_t own) const {
    const size_t first = static_cast<size_t>(node) * KdTree::kFanout;
    return {.components =
                (level == 0 ? points_ : components_[level].data()) + first,
            .own = own,
            .floors = floors_[level].data() + first};
  }

  // The number of entries of whole leaves that hold `count` points.
  static size_t RoundUp(size_t count) {
    return (count + KdTree::kFanout - 1) / KdTree::kFanout * KdTree::kFanout;
  }

 private:
  int NumChildren(int level, uint32_t node) const;

  const KdTree& tree_;
  const uint32_t* points_ = nullptr;
  // By level, and then by child of the nodes of that level.
  std::vector<std::vector<uint32_t>> components_;
  std::vector<std::vector<float>> floors_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_HDBSCAN_COMPONENT_FILTERS_H_
