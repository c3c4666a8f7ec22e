// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/scene/camera_model.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace freegs::sfm {
namespace {

constexpr std::array<CameraModelInfo, 11> kModels = {{
    {CameraModel::kSimplePinhole, "SIMPLE_PINHOLE", 3, 1},
    {CameraModel::kPinhole, "PINHOLE", 4, 2},
    {CameraModel::kSimpleRadial, "SIMPLE_RADIAL", 4, 1},
    {CameraModel::kRadial, "RADIAL", 5, 1},
    {CameraModel::kOpenCv, "OPENCV", 8, 2},
    {CameraModel::kOpenCvFisheye, "OPENCV_FISHEYE", 8, 2},
    {CameraModel::kFullOpenCv, "FULL_OPENCV", 12, 2},
    {CameraModel::kFov, "FOV", 5, 2},
    {CameraModel::kSimpleRadialFisheye, "SIMPLE_RADIAL_FISHEYE", 4, 1},
    {CameraModel::kRadialFisheye, "RADIAL_FISHEYE", 5, 1},
    {CameraModel::kThinPrismFisheye, "THIN_PRISM_FISHEYE", 12, 2},
}};

}  // namespace

std::span<const CameraModelInfo> CameraModels() { return kModels; }

const CameraModelInfo* FindCameraModel(int id) {
  return id >= 0 && id < static_cast<int>(kModels.size()) ? &kModels[id]
                                                          : nullptr;
}

const CameraModelInfo* FindCameraModel(std::string_view name) {
  const auto* it =
      std::find_if(kModels.begin(), kModels.end(), [&](const auto& info) {
        return info.name == name;
      });
  return it == kModels.end() ? nullptr : it;
}

const CameraModelInfo& GetCameraModel(CameraModel model) {
  return kModels[static_cast<size_t>(model)];
}

}  // namespace freegs::sfm
