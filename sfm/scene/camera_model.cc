// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/scene/camera_model.h"

#include <algorithm>

namespace freegs::sfm {

const CameraModelInfo* FindCameraModel(int id) {
  return id >= 0 && id < static_cast<int>(kCameraModels.size())
             ? &kCameraModels[id]
             : nullptr;
}

const CameraModelInfo* FindCameraModel(std::string_view name) {
  const auto* it = std::find_if(
      kCameraModels.begin(), kCameraModels.end(), [&](const auto& info) {
        return info.name == name;
      });
  return it == kCameraModels.end() ? nullptr : it;
}

}  // namespace freegs::sfm
