// SPDX-License-Identifier: BSD-3-Clause
// How well rendered instances agree with true masks, whatever their names.

#ifndef FREEGS_SEMANTICS_METRICS_INSTANCE_METRICS_H_
#define FREEGS_SEMANTICS_METRICS_INSTANCE_METRICS_H_

#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include <Eigen/Core>

#include "core/image.h"
#include "core/status.h"

namespace freegs::semantics {

// Pixels shared by true objects and rendered instances, of one view or summed
// over many. Truth 0 and negative instances are nobody's.
struct InstanceOverlap {
  std::map<int, int64_t> truth_pixels;                   // By object id.
  std::map<int, int64_t> instance_pixels;                // By instance id.
  std::map<std::pair<int, int>, int64_t> shared_pixels;  // (object, instance).

  void Add(const InstanceOverlap& other);

  // Intersection over union of the two masks; 0 when both are empty.
  double Iou(int object, int instance) const;
};

// Both images H x W x 1: object ids and instance ids. kInvalidArgument when
// their sizes differ.
StatusOr<InstanceOverlap> CountOverlap(const ImageU16& truth,
                                       const Image<int32_t>& instances);

// The instance with the highest IoU with an object (ties to the smaller id);
// nothing when no instance shares a pixel with it.
struct InstanceMatch {
  int instance = -1;
  double iou = 0;
};
std::optional<InstanceMatch> BestMatch(const InstanceOverlap& overlap,
                                       int object);

// Where a person who means object `id` would click: the pixel of its mask that
// is farthest from everything else, the image border included (Euclidean
// distance, the first in reading order among equals). Nothing when the object
// is not in the image.
std::optional<Eigen::Vector2i> ClickPoint(const ImageU16& truth, int id);

// Intersection over union of two masks (non-zero is inside) of the same size,
// H x W x 1; 0 when both are empty.
StatusOr<double> MaskIou(const ImageU8& a, const ImageU8& b);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_METRICS_INSTANCE_METRICS_H_
