// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/instance_pairs.h"

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

// A table, a plate on it, a seat, its legs, and a pea: parts that are their own
// instances. Each has a Gaussian, the larger ones more.
Hierarchy Furniture() {
  Hierarchy hierarchy;
  hierarchy.tree.num_leaves = 5;
  hierarchy.quality = {0.9, 0.9, 0.9, 0.9, 0.9};
  hierarchy.part_pixels = {5000, 900, 600, 300, 100};
  hierarchy.total_pixels = 10000;
  hierarchy.part_of_gaussian = {0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 3, 3, 4};
  return hierarchy;
}

RegionGraph Contacts(const std::vector<InstancePair>& pairs) {
  RegionGraph graph;
  graph.regions.resize(5);
  for (const auto& [a, b] : pairs) graph.contacts.push_back({a, b, {}});
  return graph;
}

TEST(InstancePairsTest, ThoseThatTouchAndAreOfASize) {
  const std::vector<uint8_t> no_planes(5, 0);
  const RegionGraph graph =
      Contacts({{0, 1}, {0, 2}, {1, 3}, {1, 4}, {2, 3}, {3, 4}});
  // The table is as large as a background, the pea much smaller than a plate.
  EXPECT_EQ(PairsThatMeet(Furniture(), graph, no_planes),
            (std::vector<InstancePair>{{1, 3}, {2, 3}, {3, 4}}));
  const std::vector<uint8_t> flat_plate = {0, 1, 0, 0, 0};
  EXPECT_EQ(PairsThatMeet(Furniture(), graph, flat_plate),
            (std::vector<InstancePair>{{2, 3}, {3, 4}}));
}

}  // namespace
}  // namespace freegs::semantics
