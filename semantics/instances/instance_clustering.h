// SPDX-License-Identifier: BSD-3-Clause
// Gives every Gaussian the index of an instance, from geometry, colour and
// semantics (FreeGS, "Union-space Clustering"). docs/clustering.md describes
// the steps.
//
//   FREEGS_ASSIGN_OR_RETURN(
//       const InstanceLabels instances,
//       ClusterInstances(model, SemanticVectors(), views,
//                        InstanceClusteringOptions(), seed, pool, nullptr));
//   // instances.labels[i] is the instance of Gaussian i, or -1.

#ifndef FREEGS_SEMANTICS_INSTANCES_INSTANCE_CLUSTERING_H_
#define FREEGS_SEMANTICS_INSTANCES_INSTANCE_CLUSTERING_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/cancellation.h"
#include "core/image.h"
#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "semantics/geometry/planes.h"
#include "semantics/hdbscan/hdbscan.h"
#include "semantics/instances/evidence_clustering.h"
#include "semantics/instances/hierarchy.h"
#include "semantics/instances/union_space.h"
#include "splat/render/renderer.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::semantics {

enum class ClusteringMethod {
  // What speaks for or against one thing; see evidence_clustering.h. Without
  // photographs the chain takes its place.
  kEvidence,
  kChain,  // Planes, HDBSCAN and rules; docs/clustering.md.
};

struct InstanceClusteringOptions {
  ClusteringMethod method = ClusteringMethod::kEvidence;
  EvidenceClusteringOptions evidence;

  // Gaussians of less opacity are not clustered: they are haze. They take the
  // label of their neighbourhood at the end.
  double min_opacity = 0.1;

  // Large planes are taken out before clustering; each is an instance.
  PlaneOptions planes;

  // Colours and semantic vectors are averaged over this many neighbours before
  // clustering.
  int color_neighbors = 16;

  UnionSpaceOptions space;

  // A min_cluster_size of 0 stands for 0.3 % of the Gaussians that take part,
  // and at least 30. A model with twice as many Gaussians then has the same
  // objects.
  HdbscanOptions hdbscan = {
      .min_cluster_size = 0, .min_samples = 15, .min_gap_ratio = 1.25};

  // Two clusters that touch are joined if their mean colours differ by less
  // than this (Euclidean distance, RGB in [0, 1]). 0 joins none.
  double merge_color = 0.1;

  // Two clusters touch if 0.5 % of the points of the smaller one lie within
  // this distance of the other. In scene radii.
  double merge_distance = 0.02;

  // Clusters are split where things of different colour meet in concave creases
  // (see CreaseSplitOptions::min_contrast). 0 splits none.
  double min_crease_contrast = 0.12;

  // A Gaussian without a label takes that of the nearest labelled Gaussian, if
  // it is within this distance. In scene radii.
  double noise_distance = 0.2;

  // Instances of fewer Gaussians are dissolved into their neighbours.
  int min_instance_size = 50;

  Status Check() const;
};

struct InstanceLabels {
  // For each Gaussian: -1 for none, else 0 .. num_instances - 1. Labels are
  // ordered by descending size.
  std::vector<int32_t> labels;
  int num_instances = 0;

  // For each instance: the mean membership probability of its clustered
  // Gaussians (1 for planes), and whether it is a large plane.
  std::vector<double> scores;
  std::vector<uint8_t> is_plane;

  double scene_radius = 0;  // See SceneExtent.

  // The large planes, in the order in which they were found.
  std::vector<Plane> planes;

  // What the instances were cut from, if they were.
  std::optional<Hierarchy> hierarchy;

  // Counts for people.
  size_t num_clustered = 0;     // Gaussians that took part.
  size_t num_plane_points = 0;  // Those of them that lie in large planes.
  int min_cluster_size = 0;     // What HDBSCAN was given.
  int num_clusters = 0;         // What HDBSCAN found.
  double noise_before = 0;      // Share of the clustered that were noise.
  double noise_after = 0;       // Share of all Gaussians without an instance.
};

// The semantic vectors of a field, N x dim, row-major. A vector is zero if
// nothing is known of the Gaussian. With dim 0 geometry and colour decide
// alone, which is how FreeGS begins.
struct SemanticVectors {
  std::span<const float> values;
  int dim = 0;
};

// The views whose photographs are looked at, and these.
struct PhotoViews {
  std::span<const View> views;
  std::function<StatusOr<ImageU8>(size_t view)> photo_of;
  splat::RenderOptions render;
};

// views: the cameras of the photographs, may be empty. They tell the size of
// the subject, what lies behind a plane, and which side of a surface is
// outside. The same input and seed give the same labels for any number of
// threads. kInvalidArgument for options out of range and for vectors of another
// number of Gaussians; kInterrupted when cancelled (`cancellation` may be
// null).
StatusOr<InstanceLabels> ClusterInstances(
    const splat::GaussianModel& model,
    const SemanticVectors& semantics,
    std::span<const View> views,
    const PhotoViews& photos,
    const InstanceClusteringOptions& options,
    uint64_t seed,
    ThreadPool& pool,
    const CancellationToken* cancellation);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_INSTANCE_CLUSTERING_H_
