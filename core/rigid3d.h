// SPDX-License-Identifier: BSD-3-Clause
// Rigid and similarity transforms. Names read right to left: b_from_a maps
// coordinates in frame a to coordinates in frame b.

#ifndef FREEGS_CORE_RIGID3D_H_
#define FREEGS_CORE_RIGID3D_H_

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace freegs {

// x_b = rotation * x_a + translation.
struct Rigid3d {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Matrix<double, 3, 4> Matrix3x4() const {
    Eigen::Matrix<double, 3, 4> matrix;
    matrix.leftCols<3>() = rotation.toRotationMatrix();
    matrix.col(3) = translation;
    return matrix;
  }

  Eigen::Vector3d operator*(const Eigen::Vector3d& x) const {
    return rotation * x + translation;
  }
};

// Returns a_from_b.
inline Rigid3d Inverse(const Rigid3d& b_from_a) {
  const Eigen::Quaterniond inverse = b_from_a.rotation.conjugate();
  return {inverse, inverse * -b_from_a.translation};
}

// Returns c_from_a.
inline Rigid3d operator*(const Rigid3d& c_from_b, const Rigid3d& b_from_a) {
  return {(c_from_b.rotation * b_from_a.rotation).normalized(),
          c_from_b.rotation * b_from_a.translation + c_from_b.translation};
}

// The centre of a camera in world coordinates.
inline Eigen::Vector3d CameraCentre(const Rigid3d& cam_from_world) {
  return cam_from_world.rotation.conjugate() * -cam_from_world.translation;
}

// x_b = scale * rotation * x_a + translation.
struct Sim3d {
  double scale = 1.0;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& x) const {
    return scale * (rotation * x) + translation;
  }
};

// Returns c_from_a.
inline Sim3d operator*(const Sim3d& c_from_b, const Sim3d& b_from_a) {
  return {c_from_b.scale * b_from_a.scale,
          (c_from_b.rotation * b_from_a.rotation).normalized(),
          c_from_b * b_from_a.translation};
}

// Returns a_from_b.
inline Sim3d Inverse(const Sim3d& b_from_a) {
  const Eigen::Quaterniond inverse = b_from_a.rotation.conjugate();
  return {1.0 / b_from_a.scale,
          inverse,
          (inverse * -b_from_a.translation) / b_from_a.scale};
}

// The pose, in frame b, of a camera whose pose in frame a is known. The camera
// frame takes the length unit of b: x_cam (in units of b) = result * x_b.
inline Rigid3d TransformCamera(const Sim3d& b_from_a,
                               const Rigid3d& cam_from_a) {
  Rigid3d cam_from_b;
  cam_from_b.rotation =
      (cam_from_a.rotation * b_from_a.rotation.conjugate()).normalized();
  cam_from_b.translation = b_from_a.scale * cam_from_a.translation -
                           cam_from_b.rotation * b_from_a.translation;
  return cam_from_b;
}

}  // namespace freegs

#endif  // FREEGS_CORE_RIGID3D_H_
