// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/tree_consensus.h"

#include <limits>
#include <set>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::semantics {
namespace {

constexpr double kAll = std::numeric_limits<double>::infinity();

double Contrast(const Evidence& evidence) { return evidence[kContrastNear]; }

RegionGraph Regions(size_t count) {
  RegionGraph graph;
  for (size_t i = 0; i < count; ++i) {
    RegionStats region;
    region.pixels = 9;
    region.perimeter = 20;
    graph.regions.push_back(region);
    graph.total_pixels += 9;
  }
  return graph;
}

void Touch(int32_t a, int32_t b, double contrast, RegionGraph* graph) {
  ContactStats contact;
  contact.pixels = 10;
  contact.contrast_near = 10 * contrast;
  graph->contacts.push_back({a, b, contact});
}

// A row of regions that touch their neighbours.
RegionGraph RowOf(const std::vector<double>& contrasts) {
  RegionGraph graph = Regions(contrasts.size() + 1);
  for (size_t i = 0; i < contrasts.size(); ++i) {
    Touch(static_cast<int32_t>(i),
          static_cast<int32_t>(i + 1),
          contrasts[i],
          &graph);
  }
  return graph;
}

// Width x width regions of which two halves differ by `step`.
RegionGraph TwoHalves(int32_t width, double step) {
  RegionGraph graph = Regions(size_t(width) * width);
  uint64_t drawn = 0;
  for (int32_t y = 0; y < width; ++y) {
    for (int32_t x = 0; x < width; ++x) {
      const int32_t here = y * width + x;
      const double change = RandomUniform(1, 2, drawn++) - 2;
      if (x + 1 < width) {
        Touch(here, here + 1, x + 1 == width / 2 ? step : change, &graph);
      }
      if (y + 1 < width) Touch(here, here + width, change, &graph);
    }
  }
  return graph;
}

size_t NumSets(const std::vector<int32_t>& labels) {
  return std::set<int32_t>(labels.begin(), labels.end()).size();
}

TEST(TreeConsensusTest, WithoutNoiseItIsTheTreeOfOneMerging) {
  ThreadPool pool(1);
  const RegionGraph graph = RowOf({-5, 0.5, -4.5, 1.5, -0.5});
  const StatusOr<RegionTree> tree = MergeByConsensus(
      graph, Contrast, {.num_trees = 3, .noise = 0, .lean = 0}, pool);
  ASSERT_TRUE(tree.ok()) << tree.status().message();
  const RegionTree expected = MergeRegions(graph, Contrast);
  ASSERT_EQ(tree->merges.size(), expected.merges.size());
  for (const double height : {-4.7, -1.0, 0.0, 1.0}) {
    EXPECT_EQ(NumSets(tree->Cut(height)), NumSets(expected.Cut(height)));
  }
  for (size_t k = 0; k < tree->merges.size(); ++k) {
    EXPECT_NEAR(tree->merges[k].height, expected.merges[k].height, 1e-5);
  }
}

TEST(TreeConsensusTest, ManyTreesFindWhatOneMayMiss) {
  ThreadPool pool(2);
  const StatusOr<RegionTree> tree =
      MergeByConsensus(TwoHalves(8, 2), Contrast, {}, pool);
  ASSERT_TRUE(tree.ok());
  const std::vector<int32_t> halves = tree->Cut(0);
  EXPECT_EQ(NumSets(halves), 2u);
  for (size_t i = 0; i < halves.size(); ++i) {
    EXPECT_EQ(halves[i] == halves[0], i % 8 < 4) << i;
  }
  EXPECT_EQ(NumSets(tree->Cut(kAll)), 1u);
}

TEST(TreeConsensusTest, TheSameForAnyNumberOfThreads) {
  const RegionGraph graph = TwoHalves(6, 1);
  ThreadPool one(1);
  ThreadPool three(3);
  const StatusOr<RegionTree> a = MergeByConsensus(graph, Contrast, {}, one);
  const StatusOr<RegionTree> b = MergeByConsensus(graph, Contrast, {}, three);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a->merges, b->merges);
}

TEST(TreeConsensusTest, HeightsNeverDescendAndRegionsAreJoinedOnce) {
  ThreadPool pool(1);
  const StatusOr<RegionTree> tree =
      MergeByConsensus(TwoHalves(7, 0.5), Contrast, {.max_blocks = 5}, pool);
  ASSERT_TRUE(tree.ok());
  EXPECT_EQ(tree->merges.size(), 48u);
  std::set<int32_t> joined;
  for (size_t k = 0; k < tree->merges.size(); ++k) {
    const RegionTree::Merge& merge = tree->merges[k];
    EXPECT_TRUE(joined.insert(merge.a).second);
    EXPECT_TRUE(joined.insert(merge.b).second);
    EXPECT_LT(std::max(merge.a, merge.b), 49 + static_cast<int32_t>(k));
    if (k > 0) {
      EXPECT_GE(merge.height, tree->merges[k - 1].height);
    }
  }
}

TEST(TreeConsensusTest, WhatDoesNotTouchStaysApart) {
  ThreadPool pool(1);
  RegionGraph graph = Regions(5);
  Touch(0, 1, -1, &graph);
  Touch(3, 4, -9, &graph);
  const StatusOr<RegionTree> tree = MergeByConsensus(graph, Contrast, {}, pool);
  ASSERT_TRUE(tree.ok());
  EXPECT_EQ(NumSets(tree->Cut(kAll)), 3u);
  const StatusOr<RegionTree> none =
      MergeByConsensus(RegionGraph(), Contrast, {}, pool);
  ASSERT_TRUE(none.ok());
  EXPECT_TRUE(none->merges.empty());
}

TEST(TreeConsensusTest, RefusesOptionsThatMeanNothing) {
  ThreadPool pool(1);
  for (const ConsensusOptions& options :
       {ConsensusOptions{.num_trees = 0},
        ConsensusOptions{.noise = -1},
        ConsensusOptions{.lean = std::numeric_limits<double>::quiet_NaN()},
        ConsensusOptions{.sure = 0},
        ConsensusOptions{.max_blocks = 0}}) {
    EXPECT_EQ(
        MergeByConsensus(RowOf({1}), Contrast, options, pool).status().code(),
        StatusCode::kInvalidArgument);
  }
}

}  // namespace
}  // namespace freegs::semantics
