// SPDX-License-Identifier: BSD-3-Clause
// Panoptic quality (Kirillov et al. 2019) of rendered instances: one number for
// finding objects and for outlining them.

#ifndef FREEGS_SEMANTICS_METRICS_PANOPTIC_QUALITY_H_
#define FREEGS_SEMANTICS_METRICS_PANOPTIC_QUALITY_H_

#include <cstdint>
#include <optional>

#include "semantics/metrics/instance_metrics.h"

namespace freegs::semantics {

// Counts of one view, or summed over views.
struct PanopticQuality {
  int64_t true_positives = 0;   // Pairs of object and instance, IoU > 0.5.
  int64_t false_positives = 0;  // Instances without an object.
  int64_t false_negatives = 0;  // Objects without an instance.
  double iou_sum = 0;           // Over the pairs.

  void Add(const PanopticQuality& other);

  // Each in [0, 1]; nothing when there is neither object nor instance.
  // SQ, mean IoU of the pairs; 0 without a pair.
  std::optional<double> Segmentation() const;
  // RQ = TP / (TP + FP / 2 + FN / 2).
  std::optional<double> Recognition() const;
  // PQ = SQ * RQ.
  std::optional<double> Quality() const;
};

// Matches the objects and instances of one view, all of one class. Pairs of an
// IoU above one half are unique when neither objects nor instances overlap each
// other, which is required.
//
// Truth 0 is pixels that belong to no known object. They count in the IoU of an
// instance that covers them, but an instance that lies mostly (by more than one
// half) on them, or on objects too small to be judged, is no false positive:
// nothing is known about what is there. Objects and instances of fewer than
// min_pixels are not judged.
PanopticQuality MatchSegments(const InstanceOverlap& overlap, int min_pixels);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_METRICS_PANOPTIC_QUALITY_H_
