// SPDX-License-Identifier: BSD-3-Clause
// The two kinds of boxes that the project draws around instances.

#ifndef FREEGS_SEMANTICS_GEOMETRY_BOXES_H_
#define FREEGS_SEMANTICS_GEOMETRY_BOXES_H_

#include <Eigen/Core>

namespace freegs::semantics {

// A box whose sides are parallel to the axes of the frame that it is in: the
// world, or the model frame (splat/scene/model_frame.h). Their axes have the
// same directions.
struct AxisAlignedBox {
  Eigen::Vector3d min = Eigen::Vector3d::Zero();
  Eigen::Vector3d max = Eigen::Vector3d::Zero();
};

// The points centre + rotation * x with |x_k| <= size_k / 2, in one of these
// two frames. The columns of the rotation are the directions of the sides.
struct OrientedBox {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  // Full side lengths.
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_GEOMETRY_BOXES_H_
