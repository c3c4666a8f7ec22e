// SPDX-License-Identifier: BSD-3-Clause
// The two kinds of boxes that the project draws around instances.

#ifndef FREEGS_SEMANTICS_GEOMETRY_BOXES_H_
#define FREEGS_SEMANTICS_GEOMETRY_BOXES_H_

#include <Eigen/Core>

namespace freegs::semantics {

// A box whose sides are parallel to the axes of the world frame. In world
// units.
struct AxisAlignedBox {
  Eigen::Vector3d min = Eigen::Vector3d::Zero();
  Eigen::Vector3d max = Eigen::Vector3d::Zero();
};

// The points center + rotation * x with |x_k| <= size_k / 2, in world units.
// The columns of the rotation are the directions of the sides in the world
// frame.
struct OrientedBox {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  // Full side lengths.
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_GEOMETRY_BOXES_H_
