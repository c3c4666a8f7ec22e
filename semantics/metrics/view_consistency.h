// SPDX-License-Identifier: BSD-3-Clause
// Whether two views show the same instances where both see the same surface.

#ifndef FREEGS_SEMANTICS_METRICS_VIEW_CONSISTENCY_H_
#define FREEGS_SEMANTICS_METRICS_VIEW_CONSISTENCY_H_

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "core/image.h"
#include "core/pinhole.h"
#include "core/status.h"

namespace freegs::semantics {

// What one view shows. All images have the size of its camera.
struct LabelledView {
  View view;
  Image<int32_t> labels;  // H x W; negative for none.
  ImageF depth;           // H x W: z in the camera frame, 0 where nothing is.
};

struct ViewConsistencyOptions {
  // A surface point of one view is seen by the other view if the depths there
  // differ by at most this share of the depth. Otherwise the point is hidden,
  // or its depth is not that of a surface, for example where depths blend at an
  // outline.
  double depth_tolerance = 0.02;

  // Instances with fewer pixels than this are not judged. The pixels of both
  // views count together, as far as both views see them.
  int min_pixels = 30;

  Status Check() const;
};

// Returns, for each instance, the IoU of its masks in the two views. Every
// pixel of `from` is taken to its surface point by its depth, and from there
// into `to`. The masks are compared on the pixels of `from` whose point both
// views see. Instances that neither view shows there are left out.
// kInvalidArgument for images of the wrong size and for options out of range.
StatusOr<std::map<int, double>> CompareViews(
    const LabelledView& from,
    const LabelledView& to,
    const ViewConsistencyOptions& options);

// Returns the pairs (i, j), i < j, of neighbouring views: among the views that
// look the same way (optical axes less than 60 degrees apart), the camera
// centre of j is the nearest to that of i, or the other way round. Each pair
// comes once, in ascending order.
std::vector<std::pair<size_t, size_t>> NeighbouringViews(
    const std::vector<View>& views);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_METRICS_VIEW_CONSISTENCY_H_
