// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/hierarchy.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "semantics/patches/region_joining.h"

namespace freegs::semantics {
namespace {

// A region that is less likely a whole thing is worth nothing. Without this
// limit many unlikely parts outweigh a likely whole.
constexpr double kLeastQuality = 0.1;

// How much the size of a thing counts: its share of all pixels to this power,
// at granularity 0. At granularity 1 size does not count, and beyond, small
// things count more.
constexpr double kSizeExponent = 0.0625;

// Smaller shares and larger exponents count like these, so that the worth of
// every region is a finite number: 0 has no negative power. A region with so
// few pixels is a crumb, which is never chosen, and granularities from -100 to
// 100 have exponents below 7.
constexpr double kLeastShare = 1e-6;
constexpr double kMostExponent = 40;

std::vector<int32_t> RegionsAt(const Hierarchy& hierarchy, double granularity) {
  const double exponent = std::clamp(
      kSizeExponent * (1 - granularity), -kMostExponent, kMostExponent);
  const std::vector<double> sizes = hierarchy.tree.Sums(hierarchy.part_pixels);
  std::vector<double> worth;
  for (size_t r = 0; r < sizes.size(); ++r) {
    const double share = std::clamp(
        sizes[r] / std::max(1.0, hierarchy.total_pixels), kLeastShare, 1.0);
    worth.push_back(std::pow(share, exponent) *
                    std::max(0.0, hierarchy.quality[r] - kLeastQuality));
  }
  return hierarchy.tree.MostWorth(
      worth, hierarchy.part_pixels, CrumbSize(hierarchy.total_pixels));
}

// The largest region that is this one and crumbs that were joined to it.
int32_t WithCrumbs(const Hierarchy& hierarchy, int32_t region) {
  const RegionTree& tree = hierarchy.tree;
  const std::vector<double> sizes = tree.Sums(hierarchy.part_pixels);
  for (size_t k = 0; k < tree.merges.size(); ++k) {
    const RegionTree::Merge& merge = tree.merges[k];
    if (merge.a != region && merge.b != region) continue;
    const int32_t other = merge.a == region ? merge.b : merge.a;
    if (!hierarchy.IsCrumb(sizes[other])) break;
    region = tree.num_leaves + static_cast<int32_t>(k);
  }
  return region;
}

// The smallest region that two regions are in; -1 if there is none.
int32_t RegionOfBoth(const RegionTree& tree, int32_t a, int32_t b) {
  std::vector<uint8_t> holds(tree.num_leaves + tree.merges.size(), 0);
  holds[a] |= 1;
  holds[b] |= 2;
  for (size_t k = 0; k < tree.merges.size(); ++k) {
    const size_t region = tree.num_leaves + k;
    holds[region] |= holds[tree.merges[k].a] | holds[tree.merges[k].b];
    if (holds[region] == 3) return static_cast<int32_t>(region);
  }
  return -1;
}

// For each region, whether it is the given one or in it.
std::vector<uint8_t> InsideOf(const RegionTree& tree, int32_t region) {
  std::vector<uint8_t> inside(tree.num_leaves + tree.merges.size(), 0);
  inside[region] = 1;
  for (size_t k = tree.merges.size(); k-- > 0;) {
    if (inside[tree.num_leaves + k] == 0) continue;
    inside[tree.merges[k].a] = inside[tree.merges[k].b] = 1;
  }
  return inside;
}

// Pixels of a region that belong to other instances than a and b.
double PixelsOfOthers(const Hierarchy& hierarchy,
                      const std::vector<int32_t>& instance_of_leaf,
                      int32_t region,
                      int32_t a,
                      int32_t b) {
  const std::vector<uint8_t> inside = InsideOf(hierarchy.tree, region);
  double pixels = 0;
  for (size_t leaf = 0; leaf < instance_of_leaf.size(); ++leaf) {
    const int32_t instance = instance_of_leaf[leaf];
    if (inside[leaf] != 0 && instance != a && instance != b) {
      pixels += hierarchy.part_pixels[leaf];
    }
  }
  return pixels;
}

// Counts the pixels of the leaves that are in a wrong region of the second cut.
// Leaves that belong to `whole` should be in it, and no others. The others
// should be where most of their region of the first cut is.
double PixelsOutOfPlace(const std::vector<int32_t>& before,
                        const std::vector<int32_t>& after,
                        const std::vector<uint8_t>& belongs,
                        int32_t whole,
                        std::span<const double> pixels) {
  // For each region outside, how many of its pixels each region of the second
  // cut has.
  std::map<int32_t, std::map<int32_t, double>> moved;
  double wrong = 0;
  for (size_t leaf = 0; leaf < before.size(); ++leaf) {
    if (belongs[leaf] != 0) {
      if (after[leaf] != whole) wrong += pixels[leaf];
    } else if (after[leaf] == whole) {
      wrong += pixels[leaf];
    } else {
      moved[before[leaf]][after[leaf]] += pixels[leaf];
    }
  }
  // Large regions choose first which of the second cut is theirs.
  struct Move {
    double pixels = 0;
    double most = 0;
    int32_t place = -1;
  };
  std::vector<Move> moves;
  for (const auto& [from, to] : moved) {
    Move& move = moves.emplace_back();
    for (const auto& [region, count] : to) {
      move.pixels += count;
      if (move.place >= 0 && count <= move.most) continue;
      move.most = count;
      move.place = region;
    }
  }
  std::stable_sort(
      moves.begin(), moves.end(), [](const Move& x, const Move& y) {
        return x.pixels > y.pixels;
      });
  std::set<int32_t> taken;
  for (const Move& move : moves) {
    wrong += move.pixels - (taken.insert(move.place).second ? move.most : 0);
  }
  return wrong;
}

}  // namespace

HierarchyCut CutHierarchy(const Hierarchy& hierarchy, double granularity) {
  HierarchyCut cut;
  cut.region_of_part = RegionsAt(hierarchy, granularity);
  std::map<int32_t, double> pixels;
  for (size_t p = 0; p < cut.region_of_part.size(); ++p) {
    pixels[cut.region_of_part[p]] += hierarchy.part_pixels[p];
  }
  for (int32_t& region : cut.region_of_part) {
    if (hierarchy.IsCrumb(pixels[region])) region = -1;
  }

  std::map<int32_t, size_t> gaussians;  // By region.
  for (const int32_t part : hierarchy.part_of_gaussian) {
    if (part >= 0 && cut.region_of_part[part] >= 0) {
      ++gaussians[cut.region_of_part[part]];
    }
  }
  for (const auto& [region, count] : gaussians) {
    cut.region_of_label.push_back(region);
  }
  std::stable_sort(
      cut.region_of_label.begin(),
      cut.region_of_label.end(),
      [&](int32_t a, int32_t b) { return gaussians[a] > gaussians[b]; });
  std::map<int32_t, int32_t> label;
  for (size_t k = 0; k < cut.region_of_label.size(); ++k) {
    label[cut.region_of_label[k]] = static_cast<int32_t>(k);
  }
  for (const int32_t part : hierarchy.part_of_gaussian) {
    const int32_t region = part < 0 ? -1 : cut.region_of_part[part];
    cut.label_of_gaussian.push_back(region < 0 ? -1 : label[region]);
  }
  return cut;
}

int32_t RegionAround(const Hierarchy& hierarchy, int32_t leaf, int steps) {
  const RegionTree& tree = hierarchy.tree;
  const std::vector<double> sizes = tree.Sums(hierarchy.part_pixels);
  std::vector<int32_t> parent(sizes.size(), -1);
  for (size_t k = 0; k < tree.merges.size(); ++k) {
    parent[tree.merges[k].a] = parent[tree.merges[k].b] =
        tree.num_leaves + static_cast<int32_t>(k);
  }
  // From the leaf to the root.
  std::vector<int32_t> path = {leaf};
  while (parent[path.back()] >= 0) path.push_back(parent[path.back()]);
  const int32_t own = RegionsAt(hierarchy, hierarchy.granularity)[leaf];
  auto at = std::find(path.begin(), path.end(), own);
  // A crumb is not below the region that it was given to.
  if (at == path.end()) {
    at = std::find_if(path.begin(), path.end(), [&](int32_t region) {
      return sizes[region] >= sizes[own];
    });
    if (at == path.end()) --at;
  }
  for (; steps > 0; --steps) {
    const double size = sizes[*at];
    const auto next = std::find_if(at, path.end(), [&](int32_t region) {
      return sizes[region] >= kLevelRatio * size;
    });
    at = next == path.end() ? path.end() - 1 : next;
  }
  for (; steps < 0; ++steps) {
    const double size = sizes[*at];
    while (at != path.begin() && sizes[*at] * kLevelRatio > size) --at;
  }
  return *at;
}

bool JoinAsWhole(int32_t a, int32_t b, double quality, Hierarchy* hierarchy) {
  constexpr double kMostOutOfPlace = 0.02;  // Share of the pixels of the whole.
  const std::vector<double> sizes =
      hierarchy->tree.Sums(hierarchy->part_pixels);
  const std::vector<int32_t> before =
      RegionsAt(*hierarchy, hierarchy->granularity);
  Hierarchy changed = *hierarchy;
  int32_t whole = RegionOfBoth(hierarchy->tree, a, b);
  const double others =
      whole < 0 ? 0 : PixelsOfOthers(*hierarchy, before, whole, a, b);
  if (whole < 0 || sizes[whole] > kLevelRatio * (sizes[a] + sizes[b]) ||
      others > kMostOutOfPlace * sizes[whole]) {
    // Crumbs that were joined to one of the two stay with it.
    JoinedTree joined = JoinRegions(
        hierarchy->tree, WithCrumbs(*hierarchy, a), WithCrumbs(*hierarchy, b));
    whole = joined.joined;
    changed.tree = std::move(joined.tree);
    changed.quality.assign(changed.tree.num_leaves + changed.tree.merges.size(),
                           0);
    for (size_t r = 0; r < joined.place.size(); ++r) {
      if (joined.place[r] >= 0) {
        changed.quality[joined.place[r]] = hierarchy->quality[r];
      }
    }
  }
  const std::vector<uint8_t> inside = InsideOf(changed.tree, whole);
  for (size_t r = 0; r < inside.size(); ++r) {
    if (inside[r] != 0) {
      changed.quality[r] = RoundedQuality(changed.quality[r] * (1 - quality));
    }
  }
  changed.quality[whole] = RoundedQuality(quality);
  std::vector<uint8_t> belongs;
  for (size_t leaf = 0; leaf < before.size(); ++leaf) {
    // Crumbs that lie outside may belong to the two as well. What lies inside
    // but is of a third instance does not.
    belongs.push_back(before[leaf] == a || before[leaf] == b ? 1 : 0);
  }
  const double size = changed.tree.Sums(changed.part_pixels)[whole];
  if (PixelsOutOfPlace(before,
                       RegionsAt(changed, changed.granularity),
                       belongs,
                       whole,
                       changed.part_pixels) > kMostOutOfPlace * size) {
    return false;
  }
  *hierarchy = std::move(changed);
  return true;
}

std::vector<uint8_t> GaussiansOf(const Hierarchy& hierarchy, int32_t region) {
  const std::vector<uint8_t> inside = InsideOf(hierarchy.tree, region);
  std::vector<uint8_t> result;
  for (const int32_t part : hierarchy.part_of_gaussian) {
    result.push_back(part >= 0 ? inside[part] : 0);
  }
  return result;
}

}  // namespace freegs::semantics
