// SPDX-License-Identifier: BSD-3-Clause
// Gives every Gaussian the index of an instance.
//
//   FREEGS_ASSIGN_OR_RETURN(
//       InstanceClusterer clusterer,
//       InstanceClusterer::Create(model, views, photos,
//                                 InstanceClusteringOptions(), pool, nullptr));
//   FREEGS_ASSIGN_OR_RETURN(
//       const InstanceLabels instances,
//       clusterer.Cluster(SemanticVectors(), pool, nullptr));
//   // instances.labels[i] is the instance of Gaussian i, or -1.

#ifndef FREEGS_SEMANTICS_INSTANCES_INSTANCE_CLUSTERING_H_
#define FREEGS_SEMANTICS_INSTANCES_INSTANCE_CLUSTERING_H_

#include <cstddef>
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
#include "semantics/geometry/plane.h"
#include "semantics/geometry/scene_extent.h"
#include "semantics/instances/evidence_clustering.h"
#include "semantics/instances/hierarchy.h"
#include "semantics/instances/instance_pairs.h"
#include "semantics/instances/union_clustering.h"
#include "semantics/patches/scene_patches.h"
#include "splat/render/renderer.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::semantics {

enum class ClusteringMethod {
  kEvidence,  // What speaks for or against one thing; docs/instances.md.
  kUnion,     // The paper's union space; docs/clustering.md.
};

struct InstanceClusteringOptions {
  ClusteringMethod method = ClusteringMethod::kEvidence;
  EvidenceClusteringOptions evidence;
  UnionClusteringOptions union_space;

  Status Check() const;
};

struct InstanceLabels {
  // For each Gaussian: -1 for none, else 0 .. num_instances - 1. Labels are
  // ordered by descending size.
  std::vector<int32_t> labels;
  int num_instances = 0;

  // For each instance: how sure it is one (see EvidenceClusters and
  // UnionClusters), and whether it is flat and as large as the scene. The union
  // space tells no planes.
  std::vector<double> scores;
  std::vector<uint8_t> is_plane;
  std::vector<Plane> planes;  // Those of the planes, in any order.

  // What the instances were cut from, with evidence.
  std::optional<Hierarchy> hierarchy;
  size_t division = 0;   // See EvidenceClusters.
  double agreement = 0;  // See EvidenceClusters.

  double scene_radius = 0;  // See SceneExtent.

  // Counts for people.
  size_t num_clustered = 0;  // Gaussians that did not take a neighbour's label.
  double noise_after = 0;    // Share of all Gaussians without an instance.
  int min_cluster_size = 0;  // What HDBSCAN was given; 0 for evidence.
};

struct JoinedInstances {
  InstanceLabels labels;
  // For each instance, the pair that it was made of, or twice the label that it
  // had before.
  std::vector<InstancePair> made_of;
};

// Views, and a function that returns the photograph of each.
struct PhotoViews {
  std::span<const View> views;
  std::function<StatusOr<ImageU8>(size_t view)> photo_of;
  splat::RenderOptions render;
};

class InstanceClusterer {
 public:
  // views: the cameras of all photographs, which tell the size of the subject;
  // may be empty. With kEvidence the photographs are looked at here, once,
  // however often Gaussians are clustered. The model must outlive the
  // clusterer. kInvalidArgument for options out of range and for kEvidence
  // without photographs; kInterrupted when cancelled (`cancellation` may be
  // null); errors of photo_of.
  static StatusOr<InstanceClusterer> Create(
      const splat::GaussianModel& model,
      std::span<const View> views,
      const PhotoViews& photos,
      const InstanceClusteringOptions& options,
      ThreadPool& pool,
      const CancellationToken* cancellation);

  // Gaussians that were not clustered take the label of the nearest that was,
  // if one is near. The same input gives the same labels for any number of
  // threads. kInvalidArgument for vectors of another number of Gaussians.
  StatusOr<InstanceLabels> Cluster(const SemanticVectors& semantics,
                                   ThreadPool& pool,
                                   const CancellationToken* cancellation);

  // Pairs of the instances that Cluster() found by evidence; see
  // instance_pairs.h.
  std::vector<InstancePair> PairsThatMeet(const InstanceLabels& labels) const;

  // Makes one instance of each pair, the surest first; of pairs that share an
  // instance only the surest counts. A pair whose parts cannot be had together
  // without a change elsewhere stays as it is (JoinAsWhole).
  JoinedInstances Join(const InstanceLabels& labels,
                       std::vector<WholePair> pairs) const;

 private:
  // What Cluster() returns for these clusters.
  InstanceLabels LabelsOf(EvidenceClusters clusters) const;

  InstanceClusterer(const splat::GaussianModel& model,
                    const SceneExtent& extent,
                    const InstanceClusteringOptions& options)
      : model_(&model), extent_(extent), options_(options) {}

  const splat::GaussianModel* model_;
  SceneExtent extent_;
  InstanceClusteringOptions options_;
  // For kEvidence.
  LearntModels models_;
  std::vector<ScenePatches> divisions_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_INSTANCE_CLUSTERING_H_
