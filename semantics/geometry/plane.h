// SPDX-License-Identifier: BSD-3-Clause
// A plane in space.

#ifndef FREEGS_SEMANTICS_GEOMETRY_PLANE_H_
#define FREEGS_SEMANTICS_GEOMETRY_PLANE_H_

#include <Eigen/Core>

namespace freegs::semantics {

// The points x with normal . x = offset, in the model frame
// (splat/scene/model_frame.h). |normal| = 1.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 0;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_GEOMETRY_PLANE_H_
