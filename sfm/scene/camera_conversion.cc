// SPDX-License-Identifier: BSD-3-Clause
// Fits one camera model to another.

#include "sfm/scene/camera_conversion.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/QR>

namespace freegs::sfm {
namespace {

constexpr int kAngles = 180;  // Half degrees, from the axis to 90 degrees.

double Angle(int i) { return i * std::numbers::pi / 2 / kAngles; }

// Pixel of the ray at `theta` from the axis, towards `direction` in the image,
// relative to the principal point; not finite where there is none.
Eigen::Vector2d Offset(const Camera& camera, double theta, double direction) {
  const auto pixel = Project(camera,
                             {std::sin(theta) * std::cos(direction),
                              std::sin(theta) * std::sin(direction),
                              std::cos(theta)});
  if (!pixel) return Eigen::Vector2d::Constant(std::nan(""));
  return *pixel - Eigen::Vector2d(camera.PrincipalX(), camera.PrincipalY());
}

// The distance of the farthest corner from the principal point.
double CornerDistance(const Camera& camera) {
  const double x =
      std::max(camera.PrincipalX(),
               static_cast<double>(camera.width) - camera.PrincipalX());
  const double y =
      std::max(camera.PrincipalY(),
               static_cast<double>(camera.height) - camera.PrincipalY());
  return std::hypot(x, y);
}

int NumRadial(CameraModel model) {
  switch (model) {
    case CameraModel::kSimplePinhole:
    case CameraModel::kPinhole:
      return 0;
    case CameraModel::kSimpleRadial:
      return 1;
    default:
      return 2;
  }
}

}  // namespace

Camera ConvertCamera(const Camera& camera, CameraModel model) {
  if (camera.model == model) return camera;
  // The distance from the centre, mean of both axes and of both sides, so that
  // tangential terms cancel; up to the corners, or to where it turns back.
  std::vector<double> angles;
  std::vector<double> distances;
  const double corner = CornerDistance(camera);
  for (int i = 1; i < kAngles; ++i) {
    double sum = 0;
    for (int k = 0; k < 4; ++k) {
      sum += Offset(camera, Angle(i), k * std::numbers::pi / 2).norm() / 4;
    }
    if (!(sum > (distances.empty() ? 0 : distances.back()))) break;
    angles.push_back(Angle(i));
    distances.push_back(sum);
    if (sum > corner) break;
  }

  // distance = f * (s + k1 s^3 + k2 s^5), linear in f, f k1 and f k2.
  const int terms = std::min<int>(1 + NumRadial(model), angles.size());
  double focal = (camera.FocalX() + camera.FocalY()) / 2;
  Eigen::Vector2d radial = Eigen::Vector2d::Zero();
  if (terms > 0) {
    Eigen::MatrixXd basis(angles.size(), terms);
    for (size_t i = 0; i < angles.size(); ++i) {
      const double s =
          GetCameraModel(model).fisheye ? angles[i] : std::tan(angles[i]);
      for (int k = 0; k < terms; ++k) basis(i, k) = std::pow(s, 2 * k + 1);
    }
    const Eigen::VectorXd fit = basis.colPivHouseholderQr().solve(
        Eigen::Map<const Eigen::VectorXd>(distances.data(), distances.size()));
    if (fit.allFinite() && fit[0] > 0) {
      for (int k = 1; k < terms; ++k) radial[k - 1] = fit[k] / fit[0];
      focal = fit[0];
    }
  }

  Camera converted = camera;
  converted.model = model;
  const CameraModelInfo& info = GetCameraModel(model);
  converted.params.assign(info.num_params, 0);
  const double old_focal = (camera.FocalX() + camera.FocalY()) / 2;
  converted.params[0] = focal;
  if (info.num_focal == 2) {
    converted.params[0] = focal * camera.FocalX() / old_focal;
    converted.params[1] = focal * camera.FocalY() / old_focal;
  }
  converted.params[info.num_focal] = camera.PrincipalX();
  converted.params[info.num_focal + 1] = camera.PrincipalY();
  for (int k = 0; k < NumRadial(model); ++k) {
    converted.params[info.num_focal + 2 + k] = radial[k];
  }
  return converted;
}

Status CheckLens(const Camera& camera) {
  const double side =
      static_cast<double>(std::max(camera.width, camera.height));
  const double longest = std::max(camera.FocalX(), camera.FocalY());
  const double shortest = std::min(camera.FocalX(), camera.FocalY());
  if (shortest < 0.1 * side || longest > 10 * side) {
    return UnusableResultError(
        "the focal length is beyond 0.1 to 10 times the longer side");
  }
  if (longest > 1.25 * shortest) {
    return UnusableResultError(
        "the focal lengths of x and y differ by more than a quarter");
  }
  constexpr int kDirections = 16;
  const Eigen::Vector2d size(static_cast<double>(camera.width),
                             static_cast<double>(camera.height));
  const Eigen::Vector2d centre(camera.PrincipalX(), camera.PrincipalY());
  for (int k = 0; k < kDirections; ++k) {
    const double direction = k * 2 * std::numbers::pi / kDirections;
    double last = 0;
    bool left_image = false;
    for (int i = 1; i < kAngles && !left_image; ++i) {
      const Eigen::Vector2d offset = Offset(camera, Angle(i), direction);
      const double distance = offset.norm();
      if (!(distance > last)) {
        return UnusableResultError(
            "the distortion turns back inside the image");
      }
      last = distance;
      const Eigen::Vector2d pixel = centre + offset;
      left_image =
          (pixel.array() < 0).any() || (pixel.array() > size.array()).any();
    }
    // A fisheye image may end inside the photo.
    if (!left_image && !GetCameraModel(camera.model).fisheye) {
      return UnusableResultError(
          "the distortion draws the whole half space into the image");
    }
  }
  return {};
}

}  // namespace freegs::sfm
