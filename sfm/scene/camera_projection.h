// SPDX-License-Identifier: BSD-3-Clause
// The lens distortion of COLMAP's camera models for any scalar type: double, or
// the dual numbers of Ceres. So projection and estimation use the same
// equations.

#ifndef FREEGS_SFM_SCENE_CAMERA_PROJECTION_H_
#define FREEGS_SFM_SCENE_CAMERA_PROJECTION_H_

#include <cmath>

#include <Eigen/Core>

#include "sfm/scene/camera_model.h"

namespace freegs::sfm {

template <typename T>
using Vector2 = Eigen::Matrix<T, 2, 1>;

// The shift of the normalised point (u, v) by two tangential coefficients.
template <typename T>
Vector2<T> Tangential(const Vector2<T>& uv, const T& p1, const T& p2) {
  const T r2 = uv.squaredNorm();
  const T xy = uv.x() * uv.y();
  return {2.0 * p1 * xy + p2 * (r2 + 2.0 * uv.x() * uv.x()),
          2.0 * p2 * xy + p1 * (r2 + 2.0 * uv.y() * uv.y())};
}

// Moves a normalised point, whose distance from the centre is tan(theta), to
// the distance theta.
template <typename T>
Vector2<T> Equidistant(const Vector2<T>& uv) {
  using std::atan;
  using std::sqrt;
  const T r2 = uv.squaredNorm();
  if (!(r2 > 1e-24)) return uv;  // Where the root has no derivative.
  const T r = sqrt(r2);
  return uv * T(atan(r) / r);
}

// Returns the distorted point of the normalised image coordinates (x / z, y /
// z). `distortion` points to the parameters that follow the principal point.
// The equations are those in COLMAP's documentation of its camera models.
template <typename T>
Vector2<T> Distort(CameraModel model,
                   const T* distortion,
                   const Vector2<T>& pinhole) {
  const T* d = distortion;
  switch (model) {
    case CameraModel::kSimplePinhole:
    case CameraModel::kPinhole:
      return pinhole;
    case CameraModel::kSimpleRadial:
      return pinhole * T(1.0 + d[0] * pinhole.squaredNorm());
    case CameraModel::kRadial: {
      const T r2 = pinhole.squaredNorm();
      return pinhole * T(1.0 + r2 * (d[0] + r2 * d[1]));
    }
    case CameraModel::kOpenCv: {
      const T r2 = pinhole.squaredNorm();
      return pinhole * T(1.0 + r2 * (d[0] + r2 * d[1])) +
             Tangential<T>(pinhole, d[2], d[3]);
    }
    case CameraModel::kFullOpenCv: {
      const T r2 = pinhole.squaredNorm();
      const T radial = (1.0 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]))) /
                       (1.0 + r2 * (d[5] + r2 * (d[6] + r2 * d[7])));
      return pinhole * radial + Tangential<T>(pinhole, d[2], d[3]);
    }
    case CameraModel::kFov: {
      // Devernay and Faugeras 2001: r' = atan(2 r tan(omega / 2)) / omega.
      using std::abs;
      using std::atan;
      using std::sqrt;
      using std::tan;
      const T r2 = pinhole.squaredNorm();
      const T& omega = d[0];
      if (abs(omega) < 1e-8) return pinhole;
      if (r2 < 1e-24) return pinhole * T(2.0 * tan(omega / 2.0) / omega);
      const T r = sqrt(r2);
      return pinhole * T(atan(2.0 * r * tan(omega / 2.0)) / (omega * r));
    }
    case CameraModel::kSimpleRadialFisheye: {
      const Vector2<T> uv = Equidistant<T>(pinhole);
      return uv * T(1.0 + d[0] * uv.squaredNorm());
    }
    case CameraModel::kRadialFisheye: {
      const Vector2<T> uv = Equidistant<T>(pinhole);
      const T r2 = uv.squaredNorm();
      return uv * T(1.0 + r2 * (d[0] + r2 * d[1]));
    }
    case CameraModel::kOpenCvFisheye: {
      const Vector2<T> uv = Equidistant<T>(pinhole);
      const T r2 = uv.squaredNorm();
      return uv * T(1.0 + r2 * (d[0] + r2 * (d[1] + r2 * (d[2] + r2 * d[3]))));
    }
    case CameraModel::kThinPrismFisheye: {
      const Vector2<T> uv = Equidistant<T>(pinhole);
      const T r2 = uv.squaredNorm();
      return uv * T(1.0 + r2 * (d[0] + r2 * (d[1] + r2 * (d[4] + r2 * d[5])))) +
             Tangential<T>(uv, d[2], d[3]) + Vector2<T>(d[6], d[7]) * r2;
    }
  }
  return pinhole;
}

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_CAMERA_PROJECTION_H_
