// SPDX-License-Identifier: BSD-3-Clause
// HDBSCAN: hierarchical clustering by density, with noise (Campello, Moulavi
// and Sander 2013; McInnes and Healy 2017). The clustering is exact.
//
//   FREEGS_ASSIGN_OR_RETURN(
//       const HdbscanResult clusters,
//       Hdbscan(points, dim, {.min_cluster_size = 50}, pool, nullptr));
//   // clusters.labels[i] is the cluster of point i, or -1 for noise.

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
  // The smallest number of points of a cluster, at least 2.
  int min_cluster_size = 20;

  // The core distance of a point is its distance to the min_samples-th nearest
  // other point, or to the farthest one if there are fewer. At least 1. A
  // larger number makes clusters rounder and more points noise. FreeGS uses 20
  // for LERF-Mask, and 60 for 3D-OVS and ScanNet.
  int min_samples = 20;

  // Clusters that split off at less than this distance are not split. In the
  // units of the points; 0 always splits. The program leaves this,
  // max_cluster_size and `method` as they are. They are here because the
  // published algorithm has them, and the tests compare all of it with
  // clusterings of the reference program. (The released code of FreeGS sets
  // this to 0.01 and max_cluster_size to 30000.)
  double cluster_selection_epsilon = 0;

  // Clusters of more points are split although excess of mass would keep them.
  // 0 is no limit.
  int64_t max_cluster_size = 0;

  ClusterSelection method = ClusterSelection::kExcessOfMass;

  Status Check() const;
};

struct HdbscanResult {
  int num_clusters = 0;
  std::vector<int32_t> labels;  // N; -1 is noise, else [0, num_clusters).
  // N; in [0, 1]. 0 for noise, and for what lies around more equal points than
  // min_samples.
  std::vector<float> probabilities;
  double mst_weight = 0;  // Sum of the distances along the spanning tree.
};

// points: N x dim, row-major, finite; distances are Euclidean. The result does
// not depend on the number of threads. kInvalidArgument for bad points or
// options, kInterrupted when cancelled. `cancellation` may be null.
StatusOr<HdbscanResult> Hdbscan(std::span<const float> points,
                                int dim,
                                const HdbscanOptions& options,
                                ThreadPool& pool,
                                const CancellationToken* cancellation);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_HDBSCAN_HDBSCAN_H_
