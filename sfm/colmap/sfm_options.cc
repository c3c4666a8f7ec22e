// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/colmap/sfm_options.h"

#include <algorithm>
#include <string_view>

#include "sfm/scene/camera_model.h"

namespace freegs::sfm {

int SfmOptions::FeaturesOf(int64_t num_photos) const {
  if (num_photos >= kFewPhotos || max_features >= kManyFeatures) {
    return max_features;
  }
  return std::min(kManyFeatures, 8 * max_features / 3);
}

Status SfmOptions::Check() const {
  if (camera != "auto" && camera != "single" && camera != "per_image") {
    return InvalidArgumentError("sfm.camera must be auto, single or per_image");
  }
  if (FindCameraModel(std::string_view(ColmapCameraModel())) == nullptr) {
    std::string names = "auto";
    for (const CameraModelInfo& model : CameraModels()) {
      names += ", " + std::string(model.name);
    }
    return InvalidArgumentError("sfm.camera_model must be one of " + names);
  }
  if ((max_image_size != 0 && max_image_size < 64) || max_features < 64) {
    return InvalidArgumentError(
        "sfm.max_image_size (unless 0) and sfm.max_features must be at least "
        "64");
  }
  return pairs.Check();
}

}  // namespace freegs::sfm
