// SPDX-License-Identifier: BSD-3-Clause
// Whether a scene's instances are the same from view to view. Needs no truth.

#ifndef FREEGS_STAGES_EVALUATION_CONSISTENCY_EVALUATION_H_
#define FREEGS_STAGES_EVALUATION_CONSISTENCY_EVALUATION_H_

#include <cstdint>
#include <map>
#include <optional>
#include <span>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

struct ViewConsistency {
  double mean = 0;                  // IoU over all instances of all pairs.
  int num_pairs = 0;                // Pairs of views, each compared both ways.
  std::map<int, double> instances;  // Means by instance, as in idsf.bin.
};

// instance_of_gaussian: one value per Gaussian of the scene, negative = none.
// Nothing with fewer than two neighbouring photographs or without instances in
// them. kInterrupted when cancelled.
StatusOr<std::optional<ViewConsistency>> MeasureViewConsistency(
    const WorkspaceScene& scene,
    std::span<const int32_t> instance_of_gaussian,
    const CancellationToken& cancellation,
    ThreadPool& pool);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_CONSISTENCY_EVALUATION_H_
