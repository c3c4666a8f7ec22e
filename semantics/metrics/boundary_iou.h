// SPDX-License-Identifier: BSD-3-Clause
// How well the outlines of two masks agree (Boundary IoU; Cheng et al. 2021).
// The IoU of large masks says little about their edges; this one says nothing
// about the rest.

#ifndef FREEGS_SEMANTICS_METRICS_BOUNDARY_IOU_H_
#define FREEGS_SEMANTICS_METRICS_BOUNDARY_IOU_H_

#include "core/image.h"
#include "core/status.h"

namespace freegs::semantics {

// The boundary's width in whole pixels, at least 1, in an image of this size.
int BoundaryWidth(int width, int height);

// The pixels of a mask (H x W x 1, non-zero is inside) from which at most
// `distance` steps, diagonal ones allowed, lead out of it: what eroding it
// `distance` times by a 3 x 3 square takes away. What lies beyond the image is
// outside, so that a mask cut off by the image's border has a boundary there.
// 255 on the boundary, else 0; empty only for an empty mask. kInvalidArgument
// for several channels or a distance below 1.
StatusOr<ImageU8> MaskBoundary(const ImageU8& mask, int distance);

// Intersection over union of the two masks' boundaries; 0 when both masks are
// empty. kInvalidArgument for masks of different size or several channels.
StatusOr<double> BoundaryIou(const ImageU8& a, const ImageU8& b);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_METRICS_BOUNDARY_IOU_H_
