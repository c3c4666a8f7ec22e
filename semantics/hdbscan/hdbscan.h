// SPDX-License-Identifier: BSD-3-Clause
// Hierarchical density-based clustering with noise, exact unless asked for
// less.

#ifndef FREEGS_SEMANTICS_HDBSCAN_HDBSCAN_H_
#define FREEGS_SEMANTICS_HDBSCAN_HDBSCAN_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "semantics/hdbscan/cluster_hierarchy.h"

namespace freegs::semantics {

struct HdbscanOptions {
  // Fewest points of a cluster; at least 2.
  int min_cluster_size = 20;

  // A point's core distance reaches its min_samples-th nearest other point
  // (cut to N - 1); at least 1. More makes clusters rounder and more points
  // noise. FreeGS: 20, or 60 for large scenes.
  int min_samples = 20;

  // Clusters that split off below this distance are not split (units of the
  // points). 0 always splits.
  double cluster_selection_epsilon = 0;

  // Larger clusters are split where excess of mass would keep them; 0 = never.
  int64_t max_cluster_size = 0;

  ClusterSelection method = ClusterSelection::kExcessOfMass;

  // Splits selected clusters further across clear gaps; 0 is HDBSCAN proper
  // (see ClusterSelectionOptions).
  double min_gap_ratio = 0;

  Status Check() const;
};

struct HdbscanResult {
  int num_clusters = 0;
  std::vector<int32_t> labels;       // N; -1 is noise, else [0, num_clusters).
  std::vector<float> probabilities;  // N; in (0, 1], 0 for noise.
  double mst_weight = 0;  // Sum of mutual reachability over the tree's edges.
};

// points: N x dim, row-major, finite. Euclidean distances. The result does not
// depend on the number of threads. kInvalidArgument for bad points or options,
// kInterrupted when cancelled (`cancellation` may be null).
StatusOr<HdbscanResult> Hdbscan(std::span<const float> points,
                                int dim,
                                const HdbscanOptions& options,
                                ThreadPool& pool,
                                const CancellationToken* cancellation);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_HDBSCAN_HDBSCAN_H_
