// SPDX-License-Identifier: BSD-3-Clause
// Instances from evidence: patches of surfaces are joined as long as more
// speaks for one thing than for two. docs/instances.md describes it.

#ifndef FREEGS_SEMANTICS_INSTANCES_EVIDENCE_CLUSTERING_H_
#define FREEGS_SEMANTICS_INSTANCES_EVIDENCE_CLUSTERING_H_

#include <cstdint>
#include <vector>

#include "core/status.h"
#include "semantics/geometry/plane.h"
#include "semantics/patches/evidence_model.h"
#include "semantics/patches/scene_patches.h"

namespace freegs::semantics {

struct EvidenceClusteringOptions {
  // 0 cuts where it is as likely as not that there are two things; 1 already
  // where that is e times less likely, which makes more and smaller instances,
  // and -1 the other way round.
  double granularity = 0;

  Status Check() const;
};

// The instance of each Gaussian.
struct EvidenceClusters {
  std::vector<int32_t> labels;  // Of Gaussians; -1 for none. Not numbered by
                                // size.
  // Of each label: the probability that it is a thing of its own, whether it is
  // flat and as large as the scene, and then its plane.
  std::vector<double> scores;
  std::vector<uint8_t> is_plane;
  std::vector<Plane> planes;
};

// Regions that are hardly seen have no label. scene_radius: world units.
// kInvalidArgument for options out of range.
StatusOr<EvidenceClusters> ClusterByEvidence(
    const ScenePatches& patches,
    double scene_radius,
    const EvidenceModel& model,
    const EvidenceClusteringOptions& options);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_EVIDENCE_CLUSTERING_H_
