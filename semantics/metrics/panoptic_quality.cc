// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/metrics/panoptic_quality.h"

#include <map>
#include <set>

namespace freegs::semantics {

void PanopticQuality::Add(const PanopticQuality& other) {
  true_positives += other.true_positives;
  false_positives += other.false_positives;
  false_negatives += other.false_negatives;
  iou_sum += other.iou_sum;
}

std::optional<double> PanopticQuality::Segmentation() const {
  if (true_positives + false_positives + false_negatives == 0) {
    return std::nullopt;
  }
  return true_positives == 0 ? 0
                             : iou_sum / static_cast<double>(true_positives);
}

std::optional<double> PanopticQuality::Recognition() const {
  const double all =
      static_cast<double>(true_positives) +
      0.5 * static_cast<double>(false_positives + false_negatives);
  if (all == 0) return std::nullopt;
  return static_cast<double>(true_positives) / all;
}

std::optional<double> PanopticQuality::Quality() const {
  const std::optional<double> segmentation = Segmentation();
  if (!segmentation) return std::nullopt;
  return *segmentation * *Recognition();
}

PanopticQuality MatchSegments(const InstanceOverlap& overlap, int min_pixels) {
  constexpr double kMatch = 0.5;
  PanopticQuality quality;
  std::set<int> matched_objects;
  std::set<int> matched_instances;
  std::map<int, int64_t> judged_pixels;  // By instance, on judged objects.
  const auto judged = [&](int object) {
    return overlap.truth_pixels.at(object) >= min_pixels;
  };
  for (const auto& [pair, shared] : overlap.shared_pixels) {
    const auto& [object, instance] = pair;
    if (!judged(object)) continue;
    judged_pixels[instance] += shared;
    const double iou = overlap.Iou(object, instance);
    if (iou <= kMatch) continue;
    ++quality.true_positives;
    quality.iou_sum += iou;
    matched_objects.insert(object);
    matched_instances.insert(instance);
  }
  for (const auto& [object, pixels] : overlap.truth_pixels) {
    if (judged(object) && !matched_objects.contains(object)) {
      ++quality.false_negatives;
    }
  }
  for (const auto& [instance, pixels] : overlap.instance_pixels) {
    if (pixels < min_pixels || matched_instances.contains(instance)) continue;
    const int64_t unknown = pixels - judged_pixels[instance];
    if (2 * unknown <= pixels) ++quality.false_positives;
  }
  return quality;
}

}  // namespace freegs::semantics
