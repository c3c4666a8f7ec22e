// SPDX-License-Identifier: BSD-3-Clause
// undistort/ -> reconstruct/: phase 1, a Gaussian scene from posed photos.

#ifndef FREEGS_STAGES_RECONSTRUCT_RECONSTRUCT_STAGE_H_
#define FREEGS_STAGES_RECONSTRUCT_RECONSTRUCT_STAGE_H_

#include <cstdint>
#include <memory>

#include "pipeline/stage.h"
#include "stages/reconstruct/reconstruct_options.h"

namespace freegs::stages {

std::unique_ptr<pipeline::Stage> MakeReconstructStage(
    const ReconstructStageOptions& options, uint64_t seed);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RECONSTRUCT_RECONSTRUCT_STAGE_H_
