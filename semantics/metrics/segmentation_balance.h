// SPDX-License-Identifier: BSD-3-Clause
// Whether instances are too fine or too coarse for the true objects:
// over-segmentation, under-segmentation and crumbs.

#ifndef FREEGS_SEMANTICS_METRICS_SEGMENTATION_BALANCE_H_
#define FREEGS_SEMANTICS_METRICS_SEGMENTATION_BALANCE_H_

#include <map>
#include <optional>

#include "semantics/metrics/instance_metrics.h"

namespace freegs::semantics {

// Counted in pixels, over all views of an InstanceOverlap.
struct SegmentationBalance {
  // Over-segmentation. Of each object: the instances that each cover at least a
  // tenth of those of its pixels that any instance covers; 0 where none does.
  std::map<int, int> pieces;  // By object id.

  // The mean of the above over the objects that an instance covers.
  std::optional<double> instances_per_object;

  // Under-segmentation: of how many objects an instance covers more than half,
  // mean over the instances that do so of at least one.
  std::optional<double> objects_per_instance;

  // Crumbs are instances with less than a thousandth of the pixels of all
  // instances.
  int num_instances = 0;  // With any pixel, crumbs among them.
  int num_crumbs = 0;

  // The share of all objects' pixels that no instance covers.
  std::optional<double> uncovered;
};

SegmentationBalance MeasureSegmentationBalance(const InstanceOverlap& overlap);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_METRICS_SEGMENTATION_BALANCE_H_
