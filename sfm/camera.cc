// SPDX-License-Identifier: BSD-3-Clause
// COLMAP's camera models.

#include "sfm/camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

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

// Shift of the normalised point (u, v) by two tangential coefficients.
Eigen::Vector2d Tangential(const Eigen::Vector2d& uv, double p1, double p2) {
  const double r2 = uv.squaredNorm();
  const double xy = uv.x() * uv.y();
  return {2 * p1 * xy + p2 * (r2 + 2 * uv.x() * uv.x()),
          2 * p2 * xy + p1 * (r2 + 2 * uv.y() * uv.y())};
}

// Moves a normalised point from distance tan(theta) of the centre to theta.
Eigen::Vector2d Equidistant(const Eigen::Vector2d& uv) {
  const double r = uv.norm();
  return r > 1e-12 ? Eigen::Vector2d(uv * (std::atan(r) / r)) : uv;
}

// The distorted normalised point; d are the distortion parameters.
Eigen::Vector2d Distort(CameraModel model,
                        std::span<const double> d,
                        const Eigen::Vector2d& pinhole) {
  switch (model) {
    case CameraModel::kSimplePinhole:
    case CameraModel::kPinhole:
      return pinhole;
    case CameraModel::kSimpleRadial:
      return pinhole * (1 + d[0] * pinhole.squaredNorm());
    case CameraModel::kRadial: {
      const double r2 = pinhole.squaredNorm();
      return pinhole * (1 + r2 * (d[0] + r2 * d[1]));
    }
    case CameraModel::kOpenCv: {
      const double r2 = pinhole.squaredNorm();
      return pinhole * (1 + r2 * (d[0] + r2 * d[1])) +
             Tangential(pinhole, d[2], d[3]);
    }
    case CameraModel::kFullOpenCv: {
      const double r2 = pinhole.squaredNorm();
      const double radial = (1 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]))) /
                            (1 + r2 * (d[5] + r2 * (d[6] + r2 * d[7])));
      return pinhole * radial + Tangential(pinhole, d[2], d[3]);
    }
    case CameraModel::kFov: {
      // Devernay and Faugeras 2001: r' = atan(2 r tan(omega / 2)) / omega.
      const double r = pinhole.norm();
      const double omega = d[0];
      if (std::abs(omega) < 1e-8 || r < 1e-12) return pinhole;
      return pinhole * (std::atan(2 * r * std::tan(omega / 2)) / (omega * r));
    }
    case CameraModel::kSimpleRadialFisheye: {
      const Eigen::Vector2d uv = Equidistant(pinhole);
      return uv * (1 + d[0] * uv.squaredNorm());
    }
    case CameraModel::kRadialFisheye: {
      const Eigen::Vector2d uv = Equidistant(pinhole);
      const double r2 = uv.squaredNorm();
      return uv * (1 + r2 * (d[0] + r2 * d[1]));
    }
    case CameraModel::kOpenCvFisheye: {
      const Eigen::Vector2d uv = Equidistant(pinhole);
      const double r2 = uv.squaredNorm();
      return uv * (1 + r2 * (d[0] + r2 * (d[1] + r2 * (d[2] + r2 * d[3]))));
    }
    case CameraModel::kThinPrismFisheye: {
      const Eigen::Vector2d uv = Equidistant(pinhole);
      const double r2 = uv.squaredNorm();
      return uv * (1 + r2 * (d[0] + r2 * (d[1] + r2 * (d[4] + r2 * d[5])))) +
             Tangential(uv, d[2], d[3]) + Eigen::Vector2d(d[6], d[7]) * r2;
    }
  }
  return pinhole;
}

bool IsPerspective(CameraModel model) {
  switch (model) {
    case CameraModel::kSimplePinhole:
    case CameraModel::kPinhole:
    case CameraModel::kSimpleRadial:
    case CameraModel::kRadial:
    case CameraModel::kOpenCv:
    case CameraModel::kFullOpenCv:
    case CameraModel::kFov:
      return true;
    default:
      return false;
  }
}

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

bool Camera::IsUndistorted() const {
  if (!IsPerspective(model)) return false;
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
  return {};
}

std::optional<Eigen::Vector2d> Project(const Camera& camera,
                                       const Eigen::Vector3d& point) {
  if (!(point.z() > std::numeric_limits<double>::epsilon())) return {};
  const Eigen::Vector2d uv =
      Distort(camera.model, camera.Distortion(), point.head<2>() / point.z());
  const Eigen::Vector2d pixel(camera.FocalX() * uv.x() + camera.PrincipalX(),
                              camera.FocalY() * uv.y() + camera.PrincipalY());
  if (!pixel.allFinite()) return {};
  return pixel;
}

}  // namespace freegs::sfm
