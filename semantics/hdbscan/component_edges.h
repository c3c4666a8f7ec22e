// SPDX-License-Identifier: BSD-3-Clause
// The shortest edges of components in a round of Boruvka's algorithm.

#ifndef FREEGS_SEMANTICS_HDBSCAN_COMPONENT_EDGES_H_
#define FREEGS_SEMANTICS_HDBSCAN_COMPONENT_EDGES_H_

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <mutex>
#include <vector>

#include "semantics/hdbscan/mst_edge.h"

namespace freegs::semantics {

inline constexpr MstEdge kNoEdge{
    std::numeric_limits<double>::infinity(), 0xffffffffu, 0xffffffffu};

inline MstEdge MakeEdge(double weight2, uint32_t a, uint32_t b) {
  return a < b ? MstEdge{weight2, a, b} : MstEdge{weight2, b, a};
}

// For each component, the shortest edge to another component that a round has
// found so far. Any thread may call any method. Weight2() reads without a lock:
// a stale value is too large, so that a search skips less than it could, and
// never too much.
class BestEdges {
 public:
  explicit BestEdges(size_t num_components)
      : edges_(num_components, kNoEdge), weights_(num_components) {
    for (auto& weight : weights_) weight.store(kNoEdge.weight2);
  }

  double Weight2(uint32_t component) const {
    return weights_[component].load(std::memory_order_relaxed);
  }

  MstEdge Get(uint32_t component) {
    const std::lock_guard lock(MutexOf(component));
    return edges_[component];
  }

  void Offer(uint32_t component, const MstEdge& edge) {
    if (edge.weight2 > Weight2(component)) return;
    const std::lock_guard lock(MutexOf(component));
    if (edge < edges_[component]) {
      edges_[component] = edge;
      weights_[component].store(edge.weight2, std::memory_order_relaxed);
    }
  }

 private:
  std::mutex& MutexOf(uint32_t component) {
    return mutexes_[component % mutexes_.size()];
  }

  std::vector<MstEdge> edges_;
  std::vector<std::atomic<double>> weights_;
  std::array<std::mutex, 64> mutexes_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_HDBSCAN_COMPONENT_EDGES_H_
