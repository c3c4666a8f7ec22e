// SPDX-License-Identifier: BSD-3-Clause
// Core distances of HDBSCAN and the neighbour lists they come from.

#ifndef FREEGS_SEMANTICS_HDBSCAN_CORE_DISTANCES_H_
#define FREEGS_SEMANTICS_HDBSCAN_CORE_DISTANCES_H_

#include <cstdint>
#include <vector>

#include "core/cancellation.h"
#include "core/kd_tree.h"
#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

// All arrays are in the tree's order of positions.
struct CoreDistances {
  // Squared distance to the min_samples-th nearest other point.
  std::vector<double> core2;

  // The min_samples nearest other points of each and, where there is one, the
  // next: N x list_size tree positions, nearest first.
  int list_size = 0;
  std::vector<uint32_t> neighbors;

  // Squared distance to the last point of the list; infinite when the list
  // holds all other points. No point outside the list is nearer.
  std::vector<double> last2;
};

// min_samples >= 1 is cut to N - 1. The point itself does not count (Campello
// et al. 2013). kInterrupted when cancelled.
StatusOr<CoreDistances> ComputeCoreDistances(
    const KdTree& tree,
    int min_samples,
    ThreadPool& pool,
    const CancellationToken* cancellation);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_HDBSCAN_CORE_DISTANCES_H_
