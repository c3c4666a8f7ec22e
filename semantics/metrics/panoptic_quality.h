// SPDX-License-Identifier: BSD-3-Clause
// Panoptic quality (Kirillov et al. 2019): one number for how well objects are
// found and outlined.

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

  // SQ, the mean IoU of the pairs; 0 without a pair. Like the two below in [0,
  // 1], and nothing if there is neither an object nor an instance.
  std::optional<double> Segmentation() const;
  // RQ = TP / (TP + FP / 2 + FN / 2).
  std::optional<double> Recognition() const;
  // PQ = SQ * RQ.
  std::optional<double> Quality() const;
};

// Matches the objects and instances of one view, which are all of one class.
// Objects must not overlap each other, and neither may instances; then an
// object and an instance with an IoU above one half belong to no other pair.
//
// Truth 0 stands for pixels that belong to no known object. They count in the
// IoU of an instance that covers them, other than in the paper, which takes
// pixels without truth out of the instances first. But an instance of which
// more than one half lies on them, or on objects that are too small to be
// judged, is no false positive, because nothing is known of what is there.
// Objects of fewer than min_pixels pixels are not judged, and instances of
// fewer are no false positives.
PanopticQuality MatchSegments(const InstanceOverlap& overlap, int min_pixels);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_METRICS_PANOPTIC_QUALITY_H_
