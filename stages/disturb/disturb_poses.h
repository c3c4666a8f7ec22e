// SPDX-License-Identifier: BSD-3-Clause
// Disturbs the camera poses of a reconstruction.

#ifndef FREEGS_STAGES_DISTURB_DISTURB_POSES_H_
#define FREEGS_STAGES_DISTURB_DISTURB_POSES_H_

#include <cstdint>
#include <filesystem>

#include "core/status.h"
#include "sfm/scene/reconstruction.h"
#include "stages/disturb/disturbance.h"

namespace freegs::stages {

// Turns cameras about their own centres, or scales and moves cameras and points
// together. Observations stay as they are. A disturbance of photographs changes
// nothing.
void DisturbModel(const Disturbance& disturbance,
                  uint64_t seed,
                  sfm::Reconstruction* model);

// Does so with the COLMAP model in folder `model`, and writes the result as a
// COLMAP model into the new folder `out`. In a workspace, points of poses that
// were imported without points are left out, because they were made for the
// poses as they were. kBadInput when there is no such model, and when it would
// lie too far from the origin to be read again.
Status DisturbPoses(const Disturbance& disturbance,
                    const std::filesystem::path& model,
                    const std::filesystem::path& out,
                    uint64_t seed);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_DISTURB_DISTURB_POSES_H_
