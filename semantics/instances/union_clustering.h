// SPDX-License-Identifier: BSD-3-Clause
// Instances by the paper's way: HDBSCAN of positions, colours and semantics
// side by side (FreeGS, "Union-space Clustering"). It stands beside the
// clustering by evidence for comparison. Scales, weights and limits are not the
// paper's; docs/clustering.md lists them.

#ifndef FREEGS_SEMANTICS_INSTANCES_UNION_CLUSTERING_H_
#define FREEGS_SEMANTICS_INSTANCES_UNION_CLUSTERING_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "semantics/geometry/scene_extent.h"
#include "semantics/hdbscan/hdbscan.h"
#include "semantics/instances/union_space.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::semantics {

// The semantic vectors of a field, N x dim, row-major. A vector is zero if
// nothing is known of the Gaussian. With dim 0 geometry and colour decide
// alone, which is how FreeGS begins.
struct SemanticVectors {
  std::span<const float> values;
  int dim = 0;
};

struct UnionClusteringOptions {
  UnionSpaceOptions space;

  // A min_cluster_size of 0 stands for 0.3 % of the Gaussians that take part,
  // and at least 30. A model with twice as many Gaussians then has the same
  // objects.
  HdbscanOptions hdbscan = {.min_cluster_size = 0, .min_samples = 15};

  Status Check() const;
};

struct UnionClusters {
  std::vector<int32_t> labels;  // One for each Gaussian; -1 for noise and haze.
  std::vector<double> scores;   // For each label: mean membership probability.
  int min_cluster_size = 0;     // What HDBSCAN was given.
};

// The result does not depend on the number of threads. semantics are of as many
// Gaussians as the model has. kInvalidArgument for options out of range,
// kInterrupted when cancelled (`cancellation` may be null).
StatusOr<UnionClusters> ClusterInUnionSpace(
    const splat::GaussianModel& model,
    const SemanticVectors& semantics,
    const SceneExtent& extent,
    const UnionClusteringOptions& options,
    ThreadPool& pool,
    const CancellationToken* cancellation);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_UNION_CLUSTERING_H_
