// SPDX-License-Identifier: BSD-3-Clause
// Overlap of 3D boxes.

#ifndef FREEGS_SEMANTICS_METRICS_BOX_IOU_H_
#define FREEGS_SEMANTICS_METRICS_BOX_IOU_H_

#include "semantics/geometry/boxes.h"

namespace freegs::semantics {

// Volumes in cubic world units; 0 for boxes with a negative side.
double Volume(const AxisAlignedBox& box);
double Volume(const OrientedBox& box);
double IntersectionVolume(const AxisAlignedBox& a, const AxisAlignedBox& b);
double IntersectionVolume(const OrientedBox& a, const OrientedBox& b);

// Volume of the intersection over that of the union, in [0, 1]; 0 when the
// union has no volume. Values must be finite.
double BoxIou(const AxisAlignedBox& a, const AxisAlignedBox& b);
double BoxIou(const OrientedBox& a, const OrientedBox& b);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_METRICS_BOX_IOU_H_
