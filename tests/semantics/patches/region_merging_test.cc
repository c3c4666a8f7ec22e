// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/region_merging.h"

#include <limits>
#include <set>

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

// A row of regions, of the given pixels, that touch their neighbours with the
// given steps of colour.
RegionGraph Row(const std::vector<double>& pixels,
                const std::vector<double>& steps) {
  RegionGraph graph;
  for (const double count : pixels) {
    RegionStats region;
    region.pixels = count;
    region.perimeter = 20;
    graph.regions.push_back(region);
    graph.total_pixels += count;
  }
  for (size_t i = 0; i < steps.size(); ++i) {
    ContactStats contact;
    contact.pixels = 10;
    contact.contrast_near = 10 * steps[i];
    graph.contacts.push_back(
        {static_cast<int32_t>(i), static_cast<int32_t>(i + 1), contact});
  }
  return graph;
}

double ByContrast(const Evidence& evidence) { return evidence[kContrastNear]; }

TEST(RegionMergingTest, JoinsTheMostAlikeFirst) {
  const RegionGraph graph = Row({9, 9, 9, 9}, {0.5, 0.1, 0.9});
  const RegionTree tree = MergeRegions(graph, ByContrast);
  ASSERT_EQ(tree.merges.size(), 3u);
  EXPECT_EQ(tree.merges[0].a, 1);
  EXPECT_EQ(tree.merges[0].b, 2);
  EXPECT_NEAR(tree.merges[0].height, 0.1, 1e-6);
  const std::vector<int32_t> cut = tree.Cut(0.7);
  EXPECT_EQ(cut[0], cut[1]);
  EXPECT_EQ(cut[1], cut[2]);
  EXPECT_NE(cut[2], cut[3]);
  const std::vector<int32_t> leaves = tree.Cut(0);
  EXPECT_EQ(std::set<int32_t>(leaves.begin(), leaves.end()).size(), 4u);
}

TEST(RegionMergingTest, HeightsNeverDescend) {
  const RegionTree tree =
      MergeRegions(Row({9, 9, 9, 9, 9}, {0.5, 0.4, 0.3, 0.2}), ByContrast);
  for (size_t k = 1; k < tree.merges.size(); ++k) {
    EXPECT_GE(tree.merges[k].height, tree.merges[k - 1].height);
  }
}

TEST(RegionMergingTest, RefusedPairsStayApart) {
  const RegionTree tree =
      MergeRegions(Row({9, 9, 9}, {0.2, 0.8}),
                   ByContrast,
                   [](int32_t, int32_t, const Evidence&) { return false; });
  EXPECT_TRUE(tree.merges.empty());
}

// Leaves 0 to 3; 4 is {0, 1}, 5 is {4, 2}, 6 is {5, 3}.
RegionTree Comb() {
  return {.num_leaves = 4, .merges = {{0, 1, 1}, {4, 2, 2}, {5, 3, 3}}};
}

TEST(RegionMergingTest, SumsGoUpTheTree) {
  EXPECT_EQ(Comb().Sums(std::vector<double>{1, 2, 4, 8}),
            (std::vector<double>{1, 2, 4, 8, 3, 7, 15}));
}

// What the regions of Comb are worth: leaves, then {0, 1}, {0, 1, 2} and all.
std::vector<double> Worth(double leaf, double two, double three, double all) {
  return {leaf, leaf, leaf, leaf, two, three, all};
}

TEST(RegionMergingTest, ARegionIsTakenIfItIsWorthMoreThanItsParts) {
  const std::vector<double> sizes = {100, 100, 100, 100};
  EXPECT_EQ(Comb().MostWorth(Worth(1, 1.9, 2.9, 3.9), sizes, 0),
            (std::vector<int32_t>{0, 1, 2, 3}));
  EXPECT_EQ(Comb().MostWorth(Worth(1, 2.5, 3.4, 4.4), sizes, 0),
            (std::vector<int32_t>{4, 4, 2, 3}));
  EXPECT_EQ(Comb().MostWorth(Worth(1, 2.5, 1, 9), sizes, 0),
            (std::vector<int32_t>{6, 6, 6, 6}));
}

TEST(RegionMergingTest, CrumbsStayWithTheLargestPartOfWhatTheyWereJoinedTo) {
  const std::vector<double> sizes = {100, 200, 1, 100};
  EXPECT_EQ(Comb().MostWorth(Worth(1, 1.9, 1.9, 2.9), sizes, 10),
            (std::vector<int32_t>{0, 1, 1, 3}));
  EXPECT_EQ(Comb().MostWorth(Worth(1, 2.5, 2.5, 3.4), sizes, 10),
            (std::vector<int32_t>{5, 5, 5, 3}));
  EXPECT_EQ(Comb().MostWorth(Worth(1, 2.5, 2.5, 9), sizes, 10),
            (std::vector<int32_t>{6, 6, 6, 6}));
}

TEST(RegionMergingTest, CrumbsOfCrumbsGoTheSameWay) {
  EXPECT_EQ(Comb().MostWorth(
                Worth(1, 1, 1, 1), std::vector<double>{1, 2, 3, 100}, 10),
            (std::vector<int32_t>{6, 6, 6, 6}));
}

TEST(RegionMergingTest, WhatTouchesNothingStaysACrumb) {
  const RegionTree tree = {.num_leaves = 2, .merges = {}};
  EXPECT_EQ(tree.MostWorth(
                std::vector<double>{1, 1}, std::vector<double>{1, 100}, 10),
            (std::vector<int32_t>{0, 1}));
}

TEST(RegionMergingTest, HugeNumbersDoNoHarm) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double huge : {1e308, infinity}) {
    EXPECT_EQ(
        Comb()
            .MostWorth(
                std::vector<double>(7, huge), std::vector<double>(4, huge), 0)
            .size(),
        4u);
  }
}

}  // namespace
}  // namespace freegs::semantics
