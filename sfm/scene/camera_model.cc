// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/scene/camera_model.h"

#include <algorithm>
#include <cstdint>
#include <string>

namespace freegs::sfm {
namespace {

struct NewerCameraModel {
  std::string_view name;
  int num_params;  // 0 if it is not supported.
};

// The numbers of these models begin where kCameraModels ends.
constexpr std::array<NewerCameraModel, 7> kNewerCameraModels = {{
    {"RAD_TAN_THIN_PRISM_FISHEYE", 0},
    {"SIMPLE_DIVISION", 0},
    {"DIVISION", 0},
    {"SIMPLE_FISHEYE", 3},
    {"FISHEYE", 4},
    {"EUCM", 0},
    {"EQUIRECTANGULAR", 0},
}};

StoredCameraModel AsStored(const CameraModelInfo& info) {
  return {info.model, info.num_params};
}

StatusOr<StoredCameraModel> AsStored(const NewerCameraModel& newer) {
  if (newer.num_params > 0) {
    return StoredCameraModel{CameraModel::kOpenCvFisheye, newer.num_params};
  }
  return BadInputError("camera model " + std::string(newer.name) +
                       " of newer releases of COLMAP is not supported; those "
                       "of COLMAP 3.8, SIMPLE_FISHEYE and FISHEYE are");
}

}  // namespace

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

StatusOr<StoredCameraModel> FindStoredCameraModel(int id) {
  const CameraModelInfo* info = FindCameraModel(id);
  if (info != nullptr) return AsStored(*info);
  const auto newer =
      static_cast<int64_t>(id) - static_cast<int64_t>(kCameraModels.size());
  if (newer >= 0 && newer < static_cast<int64_t>(kNewerCameraModels.size())) {
    return AsStored(kNewerCameraModels[static_cast<size_t>(newer)]);
  }
  return BadInputError("camera model number " + std::to_string(id) +
                       " is unknown");
}

StatusOr<StoredCameraModel> FindStoredCameraModel(std::string_view name) {
  const CameraModelInfo* info = FindCameraModel(name);
  if (info != nullptr) return AsStored(*info);
  const auto* newer =
      std::ranges::find(kNewerCameraModels, name, &NewerCameraModel::name);
  if (newer != kNewerCameraModels.end()) return AsStored(*newer);
  return BadInputError("unknown camera model '" +
                       std::string(name.substr(0, 64)) + "'");
}

void CompleteParameters(const StoredCameraModel& stored,
                        std::vector<double>* params) {
  const CameraModelInfo& info = GetCameraModel(stored.model);
  if (stored.num_params == info.num_params) return;
  // A fisheye without distortion: f cx cy, or fx fy cx cy.
  if (params->size() == 3) params->insert(params->begin(), params->front());
  params->resize(static_cast<size_t>(info.num_params), 0.0);
}

}  // namespace freegs::sfm
