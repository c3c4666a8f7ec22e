// SPDX-License-Identifier: BSD-3-Clause
// Measures whether a scene shows the same instances from view to view. It needs
// no truth.

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
  double mean = 0;                  // Mean IoU over all instances of all pairs.
  int num_pairs = 0;                // Each pair is compared in both directions.
  std::map<int, double> instances;  // Mean IoU by label, as in idsf.bin.
};

// Compares at most 16 photographs of the scene, rendered at a longest side of
// at most 640 pixels, each with its nearest neighbour among them; the protocol
// is in docs/evaluation.md. `instance_of_gaussian` has one label per Gaussian
// of the scene, negative for none. The result is empty when fewer than two
// photographs are neighbours or no instance is seen in them. kBadInput for
// another number of labels, kInterrupted when cancelled.
StatusOr<std::optional<ViewConsistency>> MeasureViewConsistency(
    const WorkspaceScene& scene,
    std::span<const int32_t> instance_of_gaussian,
    const CancellationToken& cancellation,
    ThreadPool& pool);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_CONSISTENCY_EVALUATION_H_
