// SPDX-License-Identifier: BSD-3-Clause
// Core distances of HDBSCAN, and the lists of neighbours that they come from.

#ifndef FREEGS_SEMANTICS_HDBSCAN_CORE_DISTANCES_H_
#define FREEGS_SEMANTICS_HDBSCAN_CORE_DISTANCES_H_

#include <cstdint>
#include <vector>

#include "core/cancellation.h"
#include "core/kd_tree.h"
#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

// Entry p of every array belongs to the point at position p of the tree.
struct CoreDistances {
  // Squared distance to the min_samples-th nearest other point.
  std::vector<double> core2;

  // N x list_size tree positions: the min_samples nearest other points of each
  // point, and the next one if there is one. Nearest first.
  int list_size = 0;
  std::vector<uint32_t> neighbors;

  // Squared distance to the last point of the list: no point outside of the
  // list is nearer. Infinite if the list holds all other points.
  std::vector<double> last2;
};

// min_samples: at least 1; N - 1 is used if it is larger. A point is not its
// own neighbour (Campello et al. 2013). kInterrupted when cancelled;
// `cancellation` may be null.
StatusOr<CoreDistances> ComputeCoreDistances(
    const KdTree& tree,
    int min_samples,
    ThreadPool& pool,
    const CancellationToken* cancellation);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_HDBSCAN_CORE_DISTANCES_H_
