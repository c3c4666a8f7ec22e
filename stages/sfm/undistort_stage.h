// SPDX-License-Identifier: BSD-3-Clause
// Stage undistort, sfm/ -> undistort/: photos and cameras without lens
// distortion. MakeUndistortStage makes the stage;
// stages/registry/stage_registry.h shows who runs it.

#ifndef FREEGS_STAGES_SFM_UNDISTORT_STAGE_H_
#define FREEGS_STAGES_SFM_UNDISTORT_STAGE_H_

#include <memory>
#include <string>

#include "pipeline/option_table.h"
#include "pipeline/stage.h"

namespace freegs::stages {

struct UndistortStageOptions {
  // Longest side in pixels of the written photos; 0 keeps their own size.
  int max_image_size = 0;
};

// Adds section [undistort] to the table, which keeps pointers to `options`.
void RegisterUndistortOptions(UndistortStageOptions& options,
                              pipeline::OptionTable& table);

// Writes images/ and sparse/ (PINHOLE cameras) with COLMAP's image_undistorter,
// and masks/ for photos that have a mask in ingest/masks.
// `colmap` is the COLMAP program: a path, or a name in PATH.
std::unique_ptr<pipeline::Stage> MakeUndistortStage(
    const UndistortStageOptions& options, const std::string& colmap);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SFM_UNDISTORT_STAGE_H_
