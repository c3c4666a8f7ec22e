// SPDX-License-Identifier: BSD-3-Clause
// Stage reconstruct, undistort/ -> reconstruct/: fits Gaussians to the posed
// photographs. This is phase 1 of the method. MakeReconstructStage makes the
// stage; stages/registry/stage_registry.h shows who runs it.

#ifndef FREEGS_STAGES_RECONSTRUCT_RECONSTRUCT_STAGE_H_
#define FREEGS_STAGES_RECONSTRUCT_RECONSTRUCT_STAGE_H_

#include <cstdint>
#include <memory>

#include "pipeline/stage.h"
#include "stages/reconstruct/reconstruct_options.h"

namespace freegs::stages {

// Reads undistort/ and the split from ingest/images.json. Writes
//   point_cloud.ply   the trained or imported Gaussians
//   metrics.json      quality on the holdout photos, size and time
//   holdout/VIEW.png  the holdout photos as the model shows them
//   exposure.json     where it was learnt, the exposure of training photos
//   progress.csv      the course of the training
//   checkpoints/      what an interrupted training goes on from
std::unique_ptr<pipeline::Stage> MakeReconstructStage(
    const ReconstructStageOptions& options, uint64_t seed);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RECONSTRUCT_RECONSTRUCT_STAGE_H_
