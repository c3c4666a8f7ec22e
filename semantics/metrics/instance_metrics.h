// SPDX-License-Identifier: BSD-3-Clause
// How well rendered instances agree with true masks. The ids of instances may
// be any: each true object is compared with the instance that fits it best.
//
//   FREEGS_ASSIGN_OR_RETURN(const InstanceOverlap overlap,
//                           CountOverlap(truth, rendered_ids));
//   const std::optional<InstanceMatch> match = BestMatch(overlap, object);
//   // match->iou says how well it fits.

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

// Counts of the pixels that true objects and rendered instances share, in one
// view or summed over many. Truth 0 and negative instances belong to nobody and
// are not counted.
struct InstanceOverlap {
  std::map<int, int64_t> truth_pixels;                   // By object id.
  std::map<int, int64_t> instance_pixels;                // By instance id.
  std::map<std::pair<int, int>, int64_t> shared_pixels;  // (object, instance).

  void Add(const InstanceOverlap& other);

  // Returns the intersection over union of the two masks, 0 if both are empty.
  double Iou(int object, int instance) const;
};

// Both images are H x W x 1: the ids of objects and of instances.
// kInvalidArgument if their sizes differ.
StatusOr<InstanceOverlap> CountOverlap(const ImageU16& truth,
                                       const Image<int32_t>& instances);

// The instance that fits an object best.
struct InstanceMatch {
  int instance = -1;
  double iou = 0;
};
// Returns the instance with the highest IoU with the object, the smaller id
// among equals. Nothing if no instance shares a pixel with the object.
std::optional<InstanceMatch> BestMatch(const InstanceOverlap& overlap,
                                       int object);

// Returns where a person who means object `id` would click: the pixel of its
// mask that is farthest from everything else and from the border of the image
// (Euclidean distance; the first in reading order among equals). Nothing if the
// object is not in the image.
std::optional<Eigen::Vector2i> ClickPoint(const ImageU16& truth, int id);

// Returns the intersection over union of two masks (H x W x 1, non-zero is
// inside), 0 if both are empty. kInvalidArgument for masks of different sizes
// or several channels.
StatusOr<double> MaskIou(const ImageU8& a, const ImageU8& b);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_METRICS_INSTANCE_METRICS_H_
