// SPDX-License-Identifier: BSD-3-Clause
// COLMAP's camera models.

#include "sfm/scene/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/number_text.h"
#include "core/pinhole.h"
#include "sfm/scene/camera_projection.h"

namespace freegs::sfm {

bool Camera::IsUndistorted() const {
  if (GetCameraModel(model).fisheye) return false;
  const std::span<const double> distortion = Distortion();
  return std::all_of(distortion.begin(), distortion.end(), [](double value) {
    return value == 0;
  });
}

Camera Camera::Resized(uint64_t new_width, uint64_t new_height) const {
  const double sx = static_cast<double>(new_width) / width;
  const double sy = static_cast<double>(new_height) / height;
  Camera resized = *this;
  resized.width = new_width;
  resized.height = new_height;
  const int num_focal = GetCameraModel(model).num_focal;
  if (num_focal == 1) {
    resized.params[0] *= (sx + sy) / 2;
  } else {
    resized.params[0] *= sx;
    resized.params[1] *= sy;
  }
  resized.params[num_focal] *= sx;
  resized.params[num_focal + 1] *= sy;
  return resized;
}

Status Camera::Check() const {
  const std::string where = "camera " + std::to_string(id);
  const CameraModelInfo* info = FindCameraModel(static_cast<int>(model));
  if (info == nullptr) return BadInputError(where + " has an unknown model");
  if (static_cast<int>(params.size()) != info->num_params) {
    return BadInputError(where + " (" + std::string(info->name) + ") needs " +
                         std::to_string(info->num_params) +
                         " parameters and has " +
                         std::to_string(params.size()));
  }
  if (!std::all_of(params.begin(), params.end(), [](double value) {
        return std::isfinite(value);
      })) {
    return BadInputError(where + " has a parameter that is not a number");
  }
  if (FocalX() <= 0 || FocalY() <= 0) {
    return BadInputError(where + " has a focal length that is not positive");
  }
  constexpr uint64_t kMaxSide = 1 << 20;
  if (width == 0 || height == 0 || width > kMaxSide || height > kMaxSide) {
    return BadInputError(where + " has an image size of " +
                         std::to_string(width) + " x " +
                         std::to_string(height) + " pixels");
  }
  // An image without distortion is up to twice as wide as the photograph that
  // it was made from (COLMAP's max_scale) and has its focal length.
  constexpr double kWidened = 2;
  const auto side = static_cast<double>(std::max(width, height));
  for (const double focal : {FocalX(), FocalY()}) {
    if (focal >= kMinFocalRatio / kWidened * side &&
        focal <= kMaxFocalRatio * side) {
      continue;
    }
    return BadInputError(
        where + " has a focal length of " + FormatSignificant(focal, 6) +
        " pixels for " + std::to_string(width) + " x " +
        std::to_string(height) +
        " pixels, which no photograph has; check its intrinsics");
  }
  return {};
}

std::optional<Eigen::Vector2d> Project(const Camera& camera,
                                       const Eigen::Vector3d& point) {
  if (!(point.z() > std::numeric_limits<double>::epsilon())) return {};
  const Eigen::Vector2d uv = Distort<double>(
      camera.model, camera.Distortion().data(), point.head<2>() / point.z());
  const Eigen::Vector2d pixel(camera.FocalX() * uv.x() + camera.PrincipalX(),
                              camera.FocalY() * uv.y() + camera.PrincipalY());
  if (!pixel.allFinite()) return {};
  return pixel;
}

}  // namespace freegs::sfm
