// SPDX-License-Identifier: BSD-3-Clause

#include "stages/viewer/viewer_levels.h"

#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::stages {
namespace {

using semantics::Hierarchy;

// Parts of random sizes, joined at random, a Gaussian in each.
Hierarchy RandomHierarchy(uint64_t seed) {
  uint64_t counter = 0;
  Hierarchy hierarchy;
  hierarchy.tree.num_leaves = 40;
  std::vector<int32_t> open;
  for (int32_t part = 0; part < hierarchy.tree.num_leaves; ++part) {
    hierarchy.part_pixels.push_back(100.0 +
                                    900.0 * RandomUniform(seed, 0, counter++));
    hierarchy.total_pixels += hierarchy.part_pixels.back();
    hierarchy.part_of_gaussian.push_back(part);
    open.push_back(part);
  }
  double height = -4;
  while (open.size() > 2) {  // Two trees remain.
    const auto take = [&] {
      const uint64_t at = RandomIndex(seed, 1, counter++, open.size());
      const int32_t region = open[at];
      open.erase(open.begin() + static_cast<std::ptrdiff_t>(at));
      return region;
    };
    const int32_t a = take();
    const int32_t b = take();
    open.push_back(hierarchy.tree.num_leaves +
                   static_cast<int32_t>(hierarchy.tree.merges.size()));
    hierarchy.tree.merges.push_back({a, b, height += 0.2});
  }
  const size_t num_regions =
      hierarchy.part_pixels.size() + hierarchy.tree.merges.size();
  for (size_t r = 0; r < num_regions; ++r) {
    hierarchy.quality.push_back(RandomUniform(seed, 2, r));
  }
  return hierarchy;
}

// The Gaussians in an interval, by their ranks.
std::vector<uint8_t> Inside(const ViewerLevels& levels, PartInterval interval) {
  std::vector<uint8_t> inside;
  for (const int32_t rank : levels.rank_of_gaussian) {
    inside.push_back(interval.begin <= rank && rank < interval.end);
  }
  return inside;
}

TEST(ViewerLevelsTest, AreThoseOfQueries) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const Hierarchy hierarchy = RandomHierarchy(seed);
    const auto cut = CutHierarchy(hierarchy, hierarchy.granularity);
    const int num_labels = static_cast<int>(cut.region_of_label.size());
    const ViewerLevels levels =
        MakeViewerLevels(hierarchy, cut.label_of_gaussian, num_labels);
    ASSERT_EQ(std::ssize(levels.of_label), num_labels);
    for (int32_t part = 0; part < hierarchy.tree.num_leaves; ++part) {
      const int32_t label = cut.label_of_gaussian[part];
      ASSERT_GE(label, 0);
      const InstanceLevels& of = levels.of_label[label];
      const auto around = [&](int steps) {
        return GaussiansOf(hierarchy, RegionAround(hierarchy, part, steps));
      };
      for (size_t k = 0; k < of.wider.size(); ++k) {
        EXPECT_EQ(Inside(levels, of.wider[k]), around(static_cast<int>(k) + 1));
      }
      EXPECT_EQ(around(static_cast<int>(of.wider.size()) + 1),
                around(static_cast<int>(of.wider.size())));
      int steps = 0;
      for (const PartInterval& interval : of.narrower) {
        const int32_t rank = levels.rank_of_gaussian[part];
        if (rank < interval.begin || rank >= interval.end) continue;
        EXPECT_EQ(Inside(levels, interval), around(--steps));
      }
    }
  }
}

TEST(ViewerLevelsTest, GaussiansOfNoPartAndInstancesWithoutParts) {
  Hierarchy hierarchy;
  hierarchy.tree = {.num_leaves = 2, .merges = {{0, 1, 1}}};
  hierarchy.quality = {0.5, 0.5, 0.2};
  hierarchy.part_pixels = {10, 20};
  hierarchy.total_pixels = 30;
  hierarchy.part_of_gaussian = {0, 1, -1};
  const ViewerLevels levels =
      MakeViewerLevels(hierarchy, std::vector<int32_t>{0, -1, 1}, 2);
  EXPECT_EQ(levels.rank_of_gaussian, (std::vector<int32_t>{0, 1, -1}));
  EXPECT_EQ(levels.of_label[0].wider,
            (std::vector<PartInterval>{PartInterval{0, 2}}));
  EXPECT_TRUE(levels.of_label[1].wider.empty());
  EXPECT_TRUE(levels.of_label[1].narrower.empty());
}

}  // namespace
}  // namespace freegs::stages
