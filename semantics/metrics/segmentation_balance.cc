// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/metrics/segmentation_balance.h"

#include <cstdint>

namespace freegs::semantics {

SegmentationBalance MeasureSegmentationBalance(const InstanceOverlap& overlap) {
  SegmentationBalance balance;
  std::map<int, int64_t> covered;  // Pixels of an object with any instance.
  for (const auto& [pair, pixels] : overlap.shared_pixels) {
    covered[pair.first] += pixels;
  }
  std::map<int, int> objects_of_instance;
  for (const auto& [pair, pixels] : overlap.shared_pixels) {
    const auto& [object, instance] = pair;
    if (pixels > 0 && 10 * pixels >= covered[object]) ++balance.pieces[object];
    if (2 * pixels > overlap.truth_pixels.at(object)) {
      ++objects_of_instance[instance];
    }
  }

  int64_t true_pixels = 0;
  int64_t covered_pixels = 0;
  int num_covered = 0;
  int num_pieces = 0;
  for (const auto& [object, pixels] : overlap.truth_pixels) {
    true_pixels += pixels;
    covered_pixels += covered[object];
    const int pieces = balance.pieces[object];
    num_pieces += pieces;
    if (pieces > 0) ++num_covered;
  }
  if (num_covered > 0) {
    balance.instances_per_object =
        static_cast<double>(num_pieces) / num_covered;
  }
  if (true_pixels > 0) {
    balance.uncovered =
        1 - static_cast<double>(covered_pixels) / double(true_pixels);
  }
  if (!objects_of_instance.empty()) {
    int sum = 0;
    for (const auto& [instance, count] : objects_of_instance) sum += count;
    balance.objects_per_instance =
        static_cast<double>(sum) / double(objects_of_instance.size());
  }

  int64_t instance_pixels = 0;
  for (const auto& [instance, pixels] : overlap.instance_pixels) {
    instance_pixels += pixels;
  }
  for (const auto& [instance, pixels] : overlap.instance_pixels) {
    if (pixels == 0) continue;
    ++balance.num_instances;
    if (1000 * pixels < instance_pixels) ++balance.num_crumbs;
  }
  return balance;
}

}  // namespace freegs::semantics
