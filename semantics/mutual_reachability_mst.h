// SPDX-License-Identifier: BSD-3-Clause
// The exact minimum spanning tree under mutual reachability distance.

#ifndef FREEGS_SEMANTICS_MUTUAL_REACHABILITY_MST_H_
#define FREEGS_SEMANTICS_MUTUAL_REACHABILITY_MST_H_

#include <cstdint>
#include <vector>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "semantics/core_distances.h"
#include "semantics/kd_tree.h"

namespace freegs::semantics {

// An edge between rows a < b.
struct MstEdge {
  // Squared mutual reachability distance:
  // max(core(a)^2, core(b)^2, |x_a - x_b|^2).
  double weight2 = 0;
  uint32_t a = 0;
  uint32_t b = 0;

  // A total order: with it the tree is unique even where weights tie, and thus
  // independent of the search order and the number of threads.
  friend bool operator<(const MstEdge& x, const MstEdge& y) {
    if (x.weight2 != y.weight2) return x.weight2 < y.weight2;
    if (x.a != y.a) return x.a < y.a;
    return x.b < y.b;
  }
  friend bool operator==(const MstEdge& x, const MstEdge& y) = default;
};

// Boruvka's algorithm with a k-d tree (March, Ram and Gray 2010, in single-tree
// form): in each round every component but the largest, to which the others
// come, finds its least edge to another one. A round first looks at the
// neighbour lists and at the edges that points found before; only points for
// which these do not settle the matter search the tree, which skips subtrees of
// one's own component and anything beyond the component's best edge so far.
// What was skipped bounds the point's later rounds.
//
// The N - 1 edges in ascending order (none for N < 2). kInterrupted when
// cancelled.
StatusOr<std::vector<MstEdge>> MutualReachabilityMst(
    const KdTree& tree,
    const CoreDistances& cores,
    ThreadPool& pool,
    const CancellationToken* cancellation);

// An approximation on a graph of neighbours: its edges join each point with the
// graph_neighbors >= 1 nearest of its list (cut to the list's size). The result
// is the graph's spanning forest, whose trees are then joined, in Boruvka's
// rounds, by the least of all edges. Never lighter than the exact tree, of
// which it may miss edges that are no graph edges.
StatusOr<std::vector<MstEdge>> NeighborGraphMst(
    const KdTree& tree,
    const CoreDistances& cores,
    int graph_neighbors,
    ThreadPool& pool,
    const CancellationToken* cancellation);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_MUTUAL_REACHABILITY_MST_H_
