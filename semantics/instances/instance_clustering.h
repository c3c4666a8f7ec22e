// SPDX-License-Identifier: BSD-3-Clause
// An instance index for every Gaussian, from geometry, colour and semantics
// (FreeGS, "Union-space Clustering").

#ifndef FREEGS_SEMANTICS_INSTANCES_INSTANCE_CLUSTERING_H_
#define FREEGS_SEMANTICS_INSTANCES_INSTANCE_CLUSTERING_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "semantics/geometry/planes.h"
#include "semantics/hdbscan/hdbscan.h"
#include "semantics/instances/union_space.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::semantics {

struct InstanceClusteringOptions {
  // Gaussians that are fainter, or whose second largest standard deviation is
  // larger (in scene radii), are not clustered: they are haze and backdrop.
  // They take the label of their neighbourhood afterwards.
  double min_opacity = 0.1;

  // Large planes become instances of their own before clustering.
  PlaneOptions planes;

  // Neighbours over which colours and semantics are averaged before clustering.
  int color_neighbors = 16;

  UnionSpaceOptions space;

  // A min_cluster_size of 0 stands for 0.3 % of the Gaussians that take part
  // (at least 30): the same objects come out of a model twice as fine.
  HdbscanOptions hdbscan = {
      .min_cluster_size = 0, .min_samples = 15, .min_gap_ratio = 1.25};

  // Clusters are joined when they touch (see merge_distance) and their mean
  // colours differ by less than this (Euclidean, RGB in [0, 1]); 0 joins none.
  double merge_color = 0.1;

  // Touching: the nearest 0.5 % of the smaller cluster's points lie within this
  // distance of the other, in scene radii.
  double merge_distance = 0.02;

  // Splits clusters in which things of different colour meet in concave creases
  // (see crease_split.h); 0 splits none. Patches of this many scene radii.
  double min_crease_contrast = 0.12;

  // Noise takes the label of the nearest labelled Gaussian up to this far away,
  // in scene radii.
  double noise_distance = 0.2;

  // Instances of fewer Gaussians are dissolved into their neighbours.
  int min_instance_size = 50;

  Status Check() const;
};

struct InstanceLabels {
  // Per Gaussian: -1 = none, 0 .. num_instances - 1 by descending size.
  std::vector<int32_t> labels;
  int num_instances = 0;

  // Per instance: mean membership probability of its clustered Gaussians (1 for
  // planes), and whether it is one of the large planes.
  std::vector<double> scores;
  std::vector<uint8_t> is_plane;

  double scene_radius = 0;  // See SceneExtent.

  // The planes, in the order found: largest first.
  std::vector<Plane> planes;

  // What happened on the way.
  size_t num_clustered = 0;     // Gaussians that took part.
  size_t num_plane_points = 0;  // Of these, in large planes.
  int min_cluster_size = 0;     // Used by HDBSCAN.
  int num_clusters = 0;         // Found by it.
  double noise_before = 0;      // Share of the clustered that were noise.
  double noise_after = 0;       // Share of all Gaussians without an instance.
};

// The semantic vectors f of a field, N x dim, row-major; zero where nothing is
// known. Without (dim 0), geometry and colour decide: how FreeGS begins.
struct SemanticVectors {
  std::span<const float> values;
  int dim = 0;
};

// views: the photographs' cameras; may be empty. They tell the size of the
// subject, and what lies behind a plane. Same input and seed, same labels,
// for any number of threads.
StatusOr<InstanceLabels> ClusterInstances(
    const splat::GaussianModel& model,
    const SemanticVectors& semantics,
    std::span<const View> views,
    const InstanceClusteringOptions& options,
    uint64_t seed,
    ThreadPool& pool,
    const CancellationToken* cancellation);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_INSTANCE_CLUSTERING_H_
