// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/union_clustering.h"

#include <algorithm>
#include <utility>

#include "semantics/geometry/directions.h"
#include "semantics/geometry/matter.h"
#include "semantics/geometry/principal_axes.h"

namespace freegs::semantics {
namespace {

// Gaussians of less opacity, and those whose second largest standard deviation
// is larger, in scene radii, are haze and backdrop: they are not clustered.
constexpr double kMinOpacity = 0.1;
constexpr double kMaxScale = 0.1;
// The min_cluster_size if none is given: this share of the Gaussians that take
// part, and at least kMinClusterSize.
constexpr double kMinClusterShare = 0.003;
constexpr int kMinClusterSize = 30;
// Principal components of the semantic vectors that are clustered (FreeGS).
constexpr int kSemanticComponents = 6;

// The directions of these rows' vectors along their first principal axes, M x
// *components.
StatusOr<std::vector<float>> SemanticComponents(
    const SemanticVectors& semantics,
    const std::vector<uint32_t>& rows,
    ThreadPool& pool,
    int* components) {
  *components = 0;
  if (semantics.dim == 0 || rows.empty()) return std::vector<float>();
  const auto dim = static_cast<size_t>(semantics.dim);
  std::vector<float> vectors(rows.size() * dim);
  for (size_t i = 0; i < rows.size(); ++i) {
    std::copy_n(
        semantics.values.data() + rows[i] * dim, dim, vectors.data() + i * dim);
  }
  MakeUnitRows(semantics.dim, vectors);
  FREEGS_ASSIGN_OR_RETURN(
      PrincipalAxes axes,
      ComputePrincipalAxes(vectors, semantics.dim, true, pool));
  axes.Keep(kSemanticComponents);
  *components = axes.count;
  return ProjectOntoAxes(axes, vectors, pool);
}

}  // namespace

Status UnionClusteringOptions::Check() const {
  FREEGS_RETURN_IF_ERROR(space.Check());
  HdbscanOptions effective = hdbscan;
  effective.min_cluster_size = std::max(2, effective.min_cluster_size);
  return effective.Check();
}

StatusOr<UnionClusters> ClusterInUnionSpace(
    const splat::GaussianModel& model,
    const SemanticVectors& semantics,
    const SceneExtent& extent,
    const UnionClusteringOptions& options,
    ThreadPool& pool,
    const CancellationToken* cancellation) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  const Matter matter =
      SelectMatter(model, kMinOpacity, kMaxScale * extent.radius);
  int components = 0;
  std::vector<float> meaning;
  if (options.space.with_semantics()) {
    FREEGS_ASSIGN_OR_RETURN(
        meaning, SemanticComponents(semantics, matter.rows, pool, &components));
  }
  const std::vector<float> points = BuildUnionSpace(matter.positions,
                                                    matter.colors,
                                                    meaning,
                                                    components,
                                                    extent,
                                                    options.space);
  UnionClusters result;
  HdbscanOptions hdbscan = options.hdbscan;
  if (hdbscan.min_cluster_size == 0) {
    hdbscan.min_cluster_size =
        std::max(kMinClusterSize,
                 static_cast<int>(kMinClusterShare *
                                  static_cast<double>(matter.rows.size())));
  }
  // One Gaussian is no cluster for HDBSCAN.
  hdbscan.min_cluster_size = std::max(2, hdbscan.min_cluster_size);
  result.min_cluster_size = hdbscan.min_cluster_size;
  FREEGS_ASSIGN_OR_RETURN(
      const HdbscanResult clusters,
      Hdbscan(points, 6 + components, hdbscan, pool, cancellation));
  result.labels.assign(model.size(), -1);
  result.scores.assign(clusters.num_clusters, 0.0);
  std::vector<double> sizes(clusters.num_clusters, 0.0);
  for (size_t i = 0; i < matter.rows.size(); ++i) {
    const int32_t label = clusters.labels[i];
    result.labels[matter.rows[i]] = label;
    if (label < 0) continue;
    result.scores[label] += clusters.probabilities[i];
    sizes[label] += 1;
  }
  for (size_t label = 0; label < sizes.size(); ++label) {
    result.scores[label] /= sizes[label];
  }
  return result;
}

}  // namespace freegs::semantics
