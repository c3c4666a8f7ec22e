// SPDX-License-Identifier: BSD-3-Clause
// The overlap of 3D boxes.

#ifndef FREEGS_SEMANTICS_METRICS_BOX_IOU_H_
#define FREEGS_SEMANTICS_METRICS_BOX_IOU_H_

#include "semantics/geometry/boxes.h"

namespace freegs::semantics {

// The volume of a box in cubic world units. A box with a negative side has
// volume 0.
double Volume(const AxisAlignedBox& box);

// The volume of the intersection over that of the union, in [0, 1]. 0 if the
// union has no volume. All numbers of the boxes must be finite.
double BoxIou(const AxisAlignedBox& a, const AxisAlignedBox& b);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_METRICS_BOX_IOU_H_
