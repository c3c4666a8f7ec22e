// SPDX-License-Identifier: BSD-3-Clause
// Which images of a reconstruction have a camera in common.

#ifndef FREEGS_SFM_CALIBRATION_CAMERA_SHARING_H_
#define FREEGS_SFM_CALIBRATION_CAMERA_SHARING_H_

#include <cstddef>
#include <string_view>

#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// Which images share their intrinsics.
enum class CameraSharing {
  kShared,    // All of one size.
  kPerGroup,  // Those that share a camera in the given model.
  kPerPhoto,  // None.
};
std::string_view CameraSharingName(CameraSharing sharing);  // "shared", ...

// How many cameras the images then have.
size_t NumCameras(const Reconstruction& model, CameraSharing sharing);

// Gives the images cameras of another model and sharing, each the nearest
// (ConvertCamera) to the one that most of its images had. Cameras of no image
// are dropped.
void AssignCameras(CameraModel camera_model,
                   CameraSharing sharing,
                   Reconstruction* model);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_CALIBRATION_CAMERA_SHARING_H_
