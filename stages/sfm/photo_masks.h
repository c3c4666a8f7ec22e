// SPDX-License-Identifier: BSD-3-Clause
// The masks of photographs (ingest/masks) on their way through stages sfm and
// undistort.

#ifndef FREEGS_STAGES_SFM_PHOTO_MASKS_H_
#define FREEGS_STAGES_SFM_PHOTO_MASKS_H_

#include "core/status.h"
#include "pipeline/stage.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::stages {

// Whether the workspace has masks of ingest.
bool HasMasks(const pipeline::StageContext& context);

// Writes masks/NAME.png below context.output for every photo NAME of `pinhole`
// that has a mask, as the photo without distortion needs it. kBadInput names a
// mask that cannot be read or has not the size of its photo's camera;
// kInterrupted when cancelled.
Status WriteUndistortedMasks(const sfm::Reconstruction& distorted,
                             const sfm::Reconstruction& pinhole,
                             const pipeline::StageContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SFM_PHOTO_MASKS_H_
