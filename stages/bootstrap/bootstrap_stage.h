// SPDX-License-Identifier: BSD-3-Clause
// reconstruct/ -> bootstrap/: phase 2, a semantic vector and an instance index
// for every Gaussian.

#ifndef FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_STAGE_H_
#define FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_STAGE_H_

#include <cstdint>
#include <memory>

#include "pipeline/stage.h"
#include "stages/bootstrap/bootstrap_options.h"

namespace freegs::stages {

// Reads reconstruct/point_cloud.ply and undistort/; writes idsf.bin,
// instances.json, instance_features.json (with semantics), metrics.json,
// instances/VIEW.png (16-bit grey, instance id, 0 = none) for every view,
// preview/VIEW.png for a few, and features/, what the network made of the
// photographs.
std::unique_ptr<pipeline::Stage> MakeBootstrapStage(
    const BootstrapStageOptions& options, uint64_t seed);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_STAGE_H_
