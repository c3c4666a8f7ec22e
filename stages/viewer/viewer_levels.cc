// SPDX-License-Identifier: BSD-3-Clause

#include "stages/viewer/viewer_levels.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <utility>

namespace freegs::stages {
namespace {

// The smallest region that is offered, as a share of the size of a crumb.
// Smaller regions are a few dots on the screen, and there are thousands of
// them.
constexpr double kSmallestRegion = 0.1;

class RegionOrder {
 public:
  explicit RegionOrder(const semantics::Hierarchy& hierarchy)
      : tree_(hierarchy.tree),
        sizes_(tree_.Sums(hierarchy.part_pixels)),
        intervals_(sizes_.size()),
        parents_(sizes_.size(), -1) {
    for (size_t k = 0; k < tree_.merges.size(); ++k) {
      parents_[tree_.merges[k].a] = parents_[tree_.merges[k].b] =
          tree_.num_leaves + static_cast<int32_t>(k);
    }
    int32_t next = 0;
    std::vector<int32_t> open;
    for (int32_t root = 0; root < std::ssize(sizes_); ++root) {
      if (parents_[root] >= 0) continue;
      open = {root};
      while (!open.empty()) {
        const int32_t region = open.back();
        open.pop_back();
        if (region < tree_.num_leaves) {
          intervals_[region] = {next, next + 1};
          ++next;
          continue;
        }
        const auto& merge = tree_.merges[region - tree_.num_leaves];
        open.push_back(merge.b);
        open.push_back(merge.a);
      }
    }
    // A merge comes after what it merges.
    for (size_t k = 0; k < tree_.merges.size(); ++k) {
      const PartInterval a = intervals_[tree_.merges[k].a];
      const PartInterval b = intervals_[tree_.merges[k].b];
      intervals_[tree_.num_leaves + k] = {std::min(a.begin, b.begin),
                                          std::max(a.end, b.end)};
    }
  }

  PartInterval interval(int32_t region) const { return intervals_[region]; }

  std::vector<PartInterval> Wider(int32_t region) const {
    std::vector<PartInterval> result;
    while (parents_[region] >= 0) {
      const double size = sizes_[region];
      // Ends at the root, which may be hardly larger.
      do {
        region = parents_[region];
      } while (parents_[region] >= 0 &&
               sizes_[region] < semantics::kLevelRatio * size);
      result.push_back(intervals_[region]);
    }
    return result;
  }

  std::vector<PartInterval> Narrower(int32_t region, double min_size) const {
    std::vector<PartInterval> result;
    // A region, and the size of the last level above it.
    std::vector<std::pair<int32_t, double>> open = {{region, sizes_[region]}};
    while (!open.empty()) {
      auto [at, level_size] = open.back();
      open.pop_back();
      if (sizes_[at] < min_size) continue;
      if (sizes_[at] * semantics::kLevelRatio <= level_size) {
        level_size = sizes_[at];
        result.push_back(intervals_[at]);
      }
      if (at < tree_.num_leaves) continue;
      const auto& merge = tree_.merges[at - tree_.num_leaves];
      open.push_back({merge.b, level_size});
      open.push_back({merge.a, level_size});
    }
    return result;
  }

 private:
  const semantics::RegionTree& tree_;
  std::vector<double> sizes_;
  std::vector<PartInterval> intervals_;
  std::vector<int32_t> parents_;
};

}  // namespace

ViewerLevels MakeViewerLevels(const semantics::Hierarchy& hierarchy,
                              std::span<const int32_t> labels,
                              int num_labels) {
  const RegionOrder order(hierarchy);
  const semantics::HierarchyCut cut =
      semantics::CutHierarchy(hierarchy, hierarchy.granularity);
  ViewerLevels levels;
  std::vector<std::map<int32_t, int64_t>> regions(num_labels);
  for (size_t g = 0; g < labels.size(); ++g) {
    const int32_t part = hierarchy.part_of_gaussian[g];
    levels.rank_of_gaussian.push_back(part < 0 ? -1
                                               : order.interval(part).begin);
    if (part < 0 || labels[g] < 0 || cut.region_of_part[part] < 0) continue;
    ++regions[labels[g]][cut.region_of_part[part]];
  }
  for (const std::map<int32_t, int64_t>& counts : regions) {
    InstanceLevels& instance = levels.of_label.emplace_back();
    if (counts.empty()) continue;
    const int32_t region = std::max_element(counts.begin(),
                                            counts.end(),
                                            [](const auto& a, const auto& b) {
                                              return a.second < b.second;
                                            })
                               ->first;
    instance.wider = order.Wider(region);
    instance.narrower = order.Narrower(
        region, kSmallestRegion * semantics::CrumbSize(hierarchy.total_pixels));
  }
  return levels;
}

}  // namespace freegs::stages
