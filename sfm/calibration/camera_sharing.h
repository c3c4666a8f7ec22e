// SPDX-License-Identifier: BSD-3-Clause
// Decides which images of a reconstruction have a camera in common.

#ifndef FREEGS_SFM_CALIBRATION_CAMERA_SHARING_H_
#define FREEGS_SFM_CALIBRATION_CAMERA_SHARING_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// Which images share their intrinsics.
enum class CameraSharing {
  kShared,    // All images of equal size.
  kPerGroup,  // Images that share a camera in the given model.
  kPerPhoto,  // None.
};

// "shared", "per_group" or "per_photo".
std::string_view CameraSharingName(CameraSharing sharing);

// The number of cameras that the images of the model have with this sharing.
size_t NumCameras(const Reconstruction& model, CameraSharing sharing);

// Replaces the cameras of a reconstruction by cameras of the given model and
// sharing. Each new camera is the one nearest (see ConvertCamera) to that which
// most of its images had. Cameras without images are removed.
void AssignCameras(CameraModel camera_model,
                   CameraSharing sharing,
                   Reconstruction* model);

// The camera that each photo, by its name, had before cameras were assigned.
using CameraGroups = std::map<std::string, uint32_t>;

// Adds the photos of a model whose cameras are still those of COLMAP.
void NoteCameraGroups(const Reconstruction& model, CameraGroups* groups);

// Makes the given groups share cameras again, so that kPerGroup means them.
// Each group gets the camera that most of its images have now.
void RestoreCameraGroups(const CameraGroups& groups, Reconstruction* model);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_CALIBRATION_CAMERA_SHARING_H_
