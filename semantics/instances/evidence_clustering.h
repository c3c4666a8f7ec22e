// SPDX-License-Identifier: BSD-3-Clause
// Instances from evidence: patches of surfaces are joined as long as more
// speaks for one thing than for two. docs/instances.md describes it.

#ifndef FREEGS_SEMANTICS_INSTANCES_EVIDENCE_CLUSTERING_H_
#define FREEGS_SEMANTICS_INSTANCES_EVIDENCE_CLUSTERING_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"
#include "semantics/geometry/plane.h"
#include "semantics/instances/hierarchy.h"
#include "semantics/patches/evidence_model.h"
#include "semantics/patches/region_quality.h"
#include "semantics/patches/scene_patches.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::semantics {

struct EvidenceClusteringOptions {
  // Above 0 there are more and smaller instances, below 0 fewer and larger ones
  // (CutHierarchy).
  double granularity = 0;

  Status Check() const;
};

struct EvidenceClusters {
  Hierarchy hierarchy;
  size_t division = 0;   // Whose patches are the leaves of the hierarchy.
  double agreement = 0;  // See DivisionChoice.

  // The instances at options.granularity, by descending size.
  std::vector<int32_t> labels;  // One for each Gaussian; -1 for none.
  // For each instance: the probability that it is a whole thing, and whether it
  // is flat and as large as the scene.
  std::vector<double> scores;
  std::vector<uint8_t> is_plane;
  std::vector<Plane> planes;  // One for each instance that is a plane.

  // Gaussians that are in a patch, and do not just follow a neighbour.
  size_t num_clustered = 0;
};

// What was learnt from drawn scenes.
struct LearntModels {
  EvidenceModel evidence;
  QualityModel quality;
};
StatusOr<LearntModels> DefaultModels();

// For each division into patches the tree of its patches, with the quality of
// each region: the mean over the trees of all divisions and their variants
// (tree_variants.h).
std::vector<Hierarchy> BuildHierarchies(std::span<const ScenePatches> divisions,
                                        const LearntModels& models,
                                        ThreadPool& pool);

struct DivisionChoice {
  size_t division = 0;

  // The mean of what each other division agrees (Agreement), 0 to 1. Where it
  // is small, chance decides where instances end. 0 if there are no others.
  double agreement = 0;
};

// The division whose instances the others agree with most (Agreement). Of
// equals the first one. It is chosen at granularity 0, so that the instances of
// any granularity are cut from one tree. seen: how many pixels each Gaussian
// covers.
DivisionChoice DivisionMostAgreedOn(std::span<const Hierarchy> hierarchies,
                                    std::span<const double> seen,
                                    ThreadPool& pool);

// The instances of a hierarchy of the patches, at its own granularity.
// scene_radius: in units of the model frame (splat/scene/model_frame.h).
EvidenceClusters CutIntoClusters(Hierarchy hierarchy,
                                 const ScenePatches& patches,
                                 double scene_radius);

// The instances of the division that the others agree with most. Gaussians in
// no patch, haze above all, and those of crumbs that touch nothing
// take the part of the nearest Gaussian that has one, if that is within
// haze_distance. This is done twice, so that haze beside haze gets a part.
// divisions: at least one. scene_radius and haze_distance: in units of the
// model frame. kInvalidArgument for options out of range.
StatusOr<EvidenceClusters> ClusterByEvidence(
    const splat::GaussianModel& model,
    std::span<const ScenePatches> divisions,
    double scene_radius,
    double haze_distance,
    const LearntModels& models,
    const EvidenceClusteringOptions& options,
    ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_EVIDENCE_CLUSTERING_H_
