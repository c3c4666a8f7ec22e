// SPDX-License-Identifier: BSD-3-Clause
// How well the outlines of two masks agree (Boundary IoU; Cheng et al. 2021).
// The plain IoU of large masks says little about their edges.

#ifndef FREEGS_SEMANTICS_METRICS_BOUNDARY_IOU_H_
#define FREEGS_SEMANTICS_METRICS_BOUNDARY_IOU_H_

#include "core/image.h"
#include "core/status.h"

namespace freegs::semantics {

// The width of a boundary in an image of this size: 2 % of the diagonal in
// whole pixels, at least 1.
int BoundaryWidth(int width, int height);

// Returns the boundary of a mask (H x W x 1, non-zero is inside): 255 on the
// boundary, else 0. The boundary is what erosion by a 3 x 3 square, `distance`
// times, takes away. Everything beyond the image is outside, so that a mask
// that the border of the image cuts has a boundary there. kInvalidArgument for
// several channels and for a distance below 1.
StatusOr<ImageU8> MaskBoundary(const ImageU8& mask, int distance);

// Returns the intersection over union of the two masks' boundaries, 0 if both
// masks are empty. kInvalidArgument for masks of different sizes or several
// channels.
StatusOr<double> BoundaryIou(const ImageU8& a, const ImageU8& b);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_METRICS_BOUNDARY_IOU_H_
