// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/hdbscan/hdbscan.h"

#include <cmath>

#include "core/kd_tree.h"
#include "semantics/hdbscan/core_distances.h"
#include "semantics/hdbscan/mutual_reachability_mst.h"

namespace freegs::semantics {

Status HdbscanOptions::Check() const {
  if (min_cluster_size < 2) {
    return InvalidArgumentError("min_cluster_size must be at least 2");
  }
  if (min_samples < 1) {
    return InvalidArgumentError("min_samples must be at least 1");
  }
  if (!(cluster_selection_epsilon >= 0)) {
    return InvalidArgumentError(
        "cluster_selection_epsilon must not be negative");
  }
  if (max_cluster_size < 0) {
    return InvalidArgumentError("max_cluster_size must not be negative");
  }
  return {};
}

StatusOr<HdbscanResult> Hdbscan(std::span<const float> points,
                                int dim,
                                const HdbscanOptions& options,
                                ThreadPool& pool,
                                const CancellationToken* cancellation) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  FREEGS_ASSIGN_OR_RETURN(const KdTree tree, KdTree::Build(points, dim));
  FREEGS_ASSIGN_OR_RETURN(
      const CoreDistances cores,
      ComputeCoreDistances(tree, options.min_samples, pool, cancellation));
  FREEGS_ASSIGN_OR_RETURN(
      const std::vector<MstEdge> mst,
      MutualReachabilityMst(tree, cores, pool, cancellation));

  const CondensedTree condensed =
      CondenseTree(mst, tree.size(), options.min_cluster_size);
  const std::vector<uint32_t> selected =
      SelectClusters(condensed,
                     {.method = options.method,
                      .epsilon = options.cluster_selection_epsilon,
                      .max_cluster_size = options.max_cluster_size});
  ClusterMembership membership = LabelPoints(condensed, selected);

  HdbscanResult result;
  result.num_clusters = static_cast<int>(selected.size());
  result.labels = std::move(membership.labels);
  result.probabilities = std::move(membership.probabilities);
  for (const MstEdge& edge : mst) result.mst_weight += std::sqrt(edge.weight2);
  return result;
}

}  // namespace freegs::semantics
