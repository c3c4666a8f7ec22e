// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/scene/two_views.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace freegs::sfm {

double RayAngleDeg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  // atan2 stays accurate near 0, where acos does not.
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
}

RayDepths FindRayDepths(const Eigen::Vector3d& ray1,
                        const Eigen::Vector3d& ray2,
                        const Eigen::Vector3d& t) {
  const double a = ray1.squaredNorm();
  const double b = ray1.dot(ray2);
  const double c = ray2.squaredNorm();
  return {b * t.dot(ray2) - c * t.dot(ray1), a * t.dot(ray2) - b * t.dot(ray1)};
}

double ShareExplained(const Eigen::Matrix3d& homography,
                      const Eigen::Matrix2Xd& pixels1,
                      const Eigen::Matrix2Xd& pixels2) {
  constexpr double kMaxErrorPx = 4;
  if (pixels1.cols() == 0) return 0;
  const Eigen::Matrix2Xd mapped =
      (homography * pixels1.colwise().homogeneous()).colwise().hnormalized();
  const auto errors = (mapped - pixels2).colwise().norm().array();
  return static_cast<double>((errors < kMaxErrorPx).count()) /
         static_cast<double>(pixels1.cols());
}

}  // namespace freegs::sfm
