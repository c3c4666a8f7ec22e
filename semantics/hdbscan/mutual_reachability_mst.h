// SPDX-License-Identifier: BSD-3-Clause
// The exact minimum spanning tree of mutual reachability distances.

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

// Returns the N - 1 edges in ascending order, or none if N < 2. kInterrupted
// when cancelled; `cancellation` may be null.
//
// The method is Boruvka's algorithm on a k-d tree (March, Ram and Gray 2010, in
// its form with a single tree). In each round every component finds its
// shortest edge to another component. The largest component does not search:
// the others find their edges to it. A round first looks at the lists of
// neighbours and at the edges that points found in earlier rounds. Only points
// for which these leave the question open search the tree. That search skips
// subtrees of the point's own component and everything that is farther than the
// best edge of the component so far. It keeps a lower bound of what it skipped,
// which may spare the point a search in later rounds.
StatusOr<std::vector<MstEdge>> MutualReachabilityMst(
    const KdTree& tree,
    const CoreDistances& cores,
    ThreadPool& pool,
    const CancellationToken* cancellation);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_HDBSCAN_MUTUAL_REACHABILITY_MST_H_
