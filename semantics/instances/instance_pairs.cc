// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/instance_pairs.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace freegs::semantics {
namespace {

constexpr double kBackgroundShare = 0.25;  // Share of all pixels.
constexpr double kLeastRatio = 0.3;        // Ratio of the sizes of a pair.

}  // namespace

std::vector<InstancePair> PairsThatMeet(const Hierarchy& hierarchy,
                                        const RegionGraph& graph,
                                        std::span<const uint8_t> is_plane) {
  const HierarchyCut cut = CutHierarchy(hierarchy, hierarchy.granularity);
  const std::vector<double> sizes = hierarchy.tree.Sums(hierarchy.part_pixels);
  std::map<int32_t, int32_t> label_of_region;
  for (size_t label = 0; label < cut.region_of_label.size(); ++label) {
    const int32_t region = cut.region_of_label[label];
    if (is_plane[label] != 0 ||
        sizes[region] > kBackgroundShare * hierarchy.total_pixels) {
      continue;
    }
    label_of_region[region] = static_cast<int32_t>(label);
  }
  std::set<std::pair<int32_t, int32_t>> pairs;
  for (const Contact& contact : graph.contacts) {
    const auto a = label_of_region.find(cut.region_of_part[contact.a]);
    const auto b = label_of_region.find(cut.region_of_part[contact.b]);
    if (a == label_of_region.end() || b == label_of_region.end() || a == b) {
      continue;
    }
    const auto [less, more] = std::minmax(sizes[a->first], sizes[b->first]);
    if (less < kLeastRatio * more) continue;
    pairs.insert(std::minmax(a->second, b->second));
  }
  std::vector<InstancePair> result;
  for (const auto& [a, b] : pairs) result.push_back({a, b});
  return result;
}

}  // namespace freegs::semantics
