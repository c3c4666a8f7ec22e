// SPDX-License-Identifier: BSD-3-Clause
// sfm/ -> undistort/: photos and cameras without lens distortion.

#ifndef FREEGS_STAGES_SFM_UNDISTORT_STAGE_H_
#define FREEGS_STAGES_SFM_UNDISTORT_STAGE_H_

#include <memory>
#include <string>

#include "pipeline/option_table.h"
#include "pipeline/stage.h"

namespace freegs::stages {

struct UndistortStageOptions {
  // Longest side in pixels of the written photos; 0 keeps their own.
  int max_image_size = 0;
};

void RegisterUndistortOptions(UndistortStageOptions& options,
                              pipeline::OptionTable& table);

// colmap: the COLMAP program (option sfm.colmap).
std::unique_ptr<pipeline::Stage> MakeUndistortStage(
    const UndistortStageOptions& options, const std::string& colmap);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SFM_UNDISTORT_STAGE_H_
