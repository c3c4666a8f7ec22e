// SPDX-License-Identifier: BSD-3-Clause
// The exact minimum spanning tree under mutual reachability distance.

#ifndef FREEGS_SEMANTICS_HDBSCAN_MUTUAL_REACHABILITY_MST_H_
#define FREEGS_SEMANTICS_HDBSCAN_MUTUAL_REACHABILITY_MST_H_

#include <cstdint>
#include <vector>

#include "core/cancellation.h"
#include "core/kd_tree.h"
#include "core/parallel.h"
#include "core/status.h"
#include "semantics/hdbscan/core_distances.h"
#include "semantics/hdbscan/mst_edge.h"

namespace freegs::semantics {

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

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_HDBSCAN_MUTUAL_REACHABILITY_MST_H_
