// SPDX-License-Identifier: BSD-3-Clause
// Whether the instances that two views show are the same where both see the
// same surface.

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

// What one view shows, all images of its camera's size.
struct LabelledView {
  View view;
  Image<int32_t> labels;  // H x W; negative = none.
  ImageF depth;           // H x W; z of the camera frame, 0 where nothing is.
};

struct ViewConsistencyOptions {
  // A surface point of one view is seen by the other when the depths there
  // agree within this share of the depth; else it is hidden, or its depth is
  // not that of a surface, as where depths blend at an outline.
  double depth_tolerance = 0.02;

  // Instances with fewer pixels than this in both views together, of those that
  // both views see, are not judged.
  int min_pixels = 30;

  Status Check() const;
};

// Instance -> IoU of its masks in the two views. Every pixel of `from` is taken
// to its surface point by the depth there and from that into `to`; the pixels
// whose point both views see are the ground on which the masks of `from` and
// `to` are compared, in the pixels of `from`. Instances that neither view shows
// there are left out. kInvalidArgument for images of the wrong size or options
// that don't pass Check().
StatusOr<std::map<int, double>> CompareViews(
    const LabelledView& from,
    const LabelledView& to,
    const ViewConsistencyOptions& options);

// Pairs (i, j), i < j, of views that are neighbours: j's camera centre is the
// nearest to i's, or i's to j's, among those that look the same way (axes less
// than 60 degrees apart). Each pair once, ascending.
std::vector<std::pair<size_t, size_t>> NeighbouringViews(
    const std::vector<View>& views);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_METRICS_VIEW_CONSISTENCY_H_
