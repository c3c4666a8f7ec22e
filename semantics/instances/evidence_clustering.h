// SPDX-License-Identifier: BSD-3-Clause
// Instances from evidence: patches of surfaces are joined as long as more
// speaks for one thing than for two. docs/instances.md describes it.

#ifndef FREEGS_SEMANTICS_INSTANCES_EVIDENCE_CLUSTERING_H_
#define FREEGS_SEMANTICS_INSTANCES_EVIDENCE_CLUSTERING_H_

#include <cstdint>
#include <vector>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "semantics/geometry/planes.h"
#include "semantics/instances/hierarchy.h"
#include "semantics/patches/evidence_model.h"
#include "semantics/patches/scene_patches.h"

namespace freegs::semantics {

struct EvidenceClusteringOptions {
  PatchOptions patches;

  // 0 cuts where it is as likely as not that there are two things; 1 already
  // where that is e times less likely, which makes more and smaller instances,
  // and -1 the other way round.
  double granularity = 0;

  Status Check() const;
};

struct EvidenceClusters {
  Hierarchy hierarchy;

  // The instances at options.granularity, by descending size.
  std::vector<int32_t> labels;  // Of Gaussians; -1 for none.
  // Of each instance: the probability that it is a thing of its own, and
  // whether it is flat and as large as the scene.
  std::vector<double> scores;
  std::vector<uint8_t> is_plane;
  std::vector<Plane> planes;  // Of those that are.
};

// Gaussians in no patch, haze above all, are in the part of the nearest
// Gaussian that is in one, if that is within PatchScene::scene_radius times
// 0.2. Errors of BuildScenePatches.
StatusOr<EvidenceClusters> ClusterByEvidence(
    const PatchScene& scene,
    const EvidenceModel& model,
    const EvidenceClusteringOptions& options,
    ThreadPool& pool,
    const CancellationToken* cancellation);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_EVIDENCE_CLUSTERING_H_
