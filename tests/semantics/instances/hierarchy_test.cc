// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/hierarchy.h"

#include <string>

#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace freegs::semantics {
namespace {

// An eye and its head (5), the body and both (6), the table, a crumb on the
// table (7), all (8). Gaussian k is in part k, and two more are in the body,
// one nowhere.
Hierarchy Duck() {
  Hierarchy hierarchy;
  hierarchy.tree = {.num_leaves = 5,
                    .merges = {{0, 1, -2}, {5, 2, -1}, {3, 4, 0.5}, {6, 7, 3}}};
  hierarchy.quality = {0.3, 0.3, 0.5, 0.9, 0, 0.6, 0.97, 0.9, 0.3};
  hierarchy.part_pixels = {1000, 9000, 30000, 60000, 1};
  hierarchy.total_pixels = 100001;
  hierarchy.part_of_gaussian = {0, 1, 2, 3, 4, 2, 2, -1};
  return hierarchy;
}

TEST(HierarchyTest, CutsAtTheGranularity) {
  const HierarchyCut whole = CutHierarchy(Duck(), 0);
  EXPECT_EQ(whole.region_of_part, (std::vector<int32_t>{6, 6, 6, 7, 7}));
  EXPECT_EQ(whole.region_of_label, (std::vector<int32_t>{6, 7}));
  EXPECT_EQ(whole.label_of_gaussian,
            (std::vector<int32_t>{0, 0, 0, 1, 1, 0, 0, -1}));
  const HierarchyCut parts = CutHierarchy(Duck(), 1);
  EXPECT_EQ(parts.region_of_part, (std::vector<int32_t>{5, 5, 2, 7, 7}));
  const HierarchyCut all = CutHierarchy(Duck(), -80);
  EXPECT_EQ(all.region_of_label, (std::vector<int32_t>{8}));
  // The smallest things of all, but no crumbs.
  for (const double finest : {100.0, 1e9}) {
    const std::vector<int32_t> regions =
        CutHierarchy(Duck(), finest).region_of_part;
    EXPECT_EQ(std::vector<int32_t>(regions.begin(), regions.begin() + 3),
              (std::vector<int32_t>{0, 1, 2}));
    EXPECT_EQ(regions[3], regions[4]);
  }
}

TEST(HierarchyTest, WhatIsHardlySeenIsNobodys) {
  Hierarchy hierarchy = Duck();
  hierarchy.tree.merges.erase(hierarchy.tree.merges.begin() + 2,
                              hierarchy.tree.merges.end());
  hierarchy.quality.resize(7);
  EXPECT_EQ(CutHierarchy(hierarchy, 0).region_of_part,
            (std::vector<int32_t>{6, 6, 6, 3, -1}));
}

TEST(HierarchyTest, LevelsLeadFromThePartToTheWhole) {
  const Hierarchy hierarchy = Duck();
  EXPECT_EQ(RegionAround(hierarchy, 0, 0), 6);   // The duck.
  EXPECT_EQ(RegionAround(hierarchy, 0, -1), 5);  // Its head.
  EXPECT_EQ(RegionAround(hierarchy, 0, -2), 0);  // Its eye.
  EXPECT_EQ(RegionAround(hierarchy, 0, -9), 0);
  EXPECT_EQ(RegionAround(hierarchy, 0, 1), 8);
  EXPECT_EQ(RegionAround(hierarchy, 0, 9), 8);
  // The crumb begins where it was put.
  EXPECT_EQ(RegionAround(hierarchy, 4, 1), 8);
}

// A seat (5), its legs (2) with a crumb (6), a rug (4); the seat was joined to
// the rug (7) before its legs came (8).
Hierarchy Stool() {
  Hierarchy hierarchy;
  hierarchy.tree = {.num_leaves = 5,
                    .merges = {{0, 1, -2}, {2, 3, -1}, {5, 4, 1}, {7, 6, 2}}};
  hierarchy.quality = {0.2, 0.2, 0.4, 0, 0.9, 0.8, 0.4, 0.3, 0.3};
  hierarchy.part_pixels = {2000, 4000, 3000, 1, 9000};
  hierarchy.total_pixels = 100000;
  hierarchy.part_of_gaussian = {0, 1, 1, 2, 3, 4, 4, 4, 4, -1};
  return hierarchy;
}

TEST(HierarchyTest, TwoInstancesBecomeOneWhole) {
  Hierarchy hierarchy = Stool();
  const std::vector<int32_t> before = CutHierarchy(hierarchy, 0).region_of_part;
  EXPECT_EQ(before, (std::vector<int32_t>{5, 5, 6, 6, 4}));
  ASSERT_TRUE(JoinAsWhole(5, 6, 0.85, &hierarchy));
  const HierarchyCut cut = CutHierarchy(hierarchy, 0);
  const int32_t stool = cut.region_of_part[0];
  EXPECT_EQ(cut.region_of_part,
            (std::vector<int32_t>{stool, stool, stool, stool, 4}));
  EXPECT_EQ(hierarchy.quality[stool], 0.85);
  // The seat is a part of a thing, as surely as that is one.
  EXPECT_NEAR(hierarchy.quality[RegionAround(hierarchy, 1, -1)], 0.12, 1e-9);
  EXPECT_EQ(GaussiansOf(hierarchy, stool),
            (std::vector<uint8_t>{1, 1, 1, 1, 1, 0, 0, 0, 0, 0}));
  // The file has a place for it.
  const auto read = ParseHierarchy(SerializeHierarchy(hierarchy));
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(CutHierarchy(*read, 0).region_of_part, cut.region_of_part);
}

TEST(HierarchyTest, AThirdInstanceIsNotLostInAWhole) {
  // So small a rug would make the region of all three (8) hardly larger than
  // the stool.
  Hierarchy hierarchy = Stool();
  hierarchy.part_pixels[4] = 1500;
  EXPECT_EQ(CutHierarchy(hierarchy, 0).region_of_part,
            (std::vector<int32_t>{5, 5, 6, 6, 4}));
  ASSERT_TRUE(JoinAsWhole(5, 6, 0.85, &hierarchy));
  const HierarchyCut cut = CutHierarchy(hierarchy, 0);
  EXPECT_EQ(cut.region_of_label.size(), 2u);
  EXPECT_EQ(cut.region_of_part[4], 4);
}

TEST(HierarchyTest, AWholeThatWouldChangeOthersIsNone) {
  // A stool that is hardly a thing is worth less than seat and legs were. Then
  // the region of all three (8) is worth most, and the rug would be in it.
  Hierarchy hierarchy = Stool();
  hierarchy.quality[8] = 0.99;
  hierarchy.quality[4] = 0.5;
  const Hierarchy before = hierarchy;
  ASSERT_EQ(CutHierarchy(before, 0).region_of_label.size(), 3u);
  EXPECT_FALSE(JoinAsWhole(5, 6, 0.4, &hierarchy));
  EXPECT_EQ(hierarchy.tree.merges, before.tree.merges);
  EXPECT_EQ(hierarchy.quality, before.quality);
}

TEST(HierarchyTest, GaussiansOfARegionAreThoseOfItsParts) {
  EXPECT_EQ(GaussiansOf(Duck(), 5),
            (std::vector<uint8_t>{1, 1, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(GaussiansOf(Duck(), 8),
            (std::vector<uint8_t>{1, 1, 1, 1, 1, 1, 1, 0}));
}

TEST(HierarchyTest, ComesBackAsWritten) {
  const TemporaryFolder folder;
  Hierarchy hierarchy = Duck();
  hierarchy.granularity = 0.1;
  const std::string path = folder / "hierarchy.json";
  ASSERT_TRUE(WriteHierarchy(path, hierarchy).ok());
  const StatusOr<Hierarchy> read = ReadHierarchy(path, 8);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->tree.num_leaves, 5);
  EXPECT_EQ(read->tree.merges, hierarchy.tree.merges);
  EXPECT_EQ(read->quality, hierarchy.quality);
  EXPECT_EQ(read->part_pixels, hierarchy.part_pixels);
  EXPECT_EQ(read->total_pixels, hierarchy.total_pixels);
  EXPECT_EQ(read->part_of_gaussian, hierarchy.part_of_gaussian);
  EXPECT_EQ(read->granularity, hierarchy.granularity);
  EXPECT_EQ(ReadHierarchy(path, 9).status().code(), StatusCode::kBadInput);
}

TEST(HierarchyTest, TruncatedTextIsAnErrorEverywhere) {
  const std::string text = SerializeHierarchy(Duck());
  for (size_t length = 0; length + 2 < text.size(); ++length) {
    EXPECT_EQ(ParseHierarchy(text.substr(0, length)).status().code(),
              StatusCode::kBadInput)
        << length;
  }
}

TEST(HierarchyTest, HostileTreesAreErrors) {
  const std::string head = R"({"granularity": 0, "total_pixels": 9, )";
  for (const char* rest :
       {R"("part_pixels": [1, 2], "merges": [[0, 0, 1]],
           "quality": [0, 0, 0], "part_of_gaussian": []})",
        R"("part_pixels": [1, 2], "merges": [[0, 2, 1]],
           "quality": [0, 0, 0], "part_of_gaussian": []})",
        R"("part_pixels": [1, 2, 3], "merges": [[0, 1, 1], [0, 2, 2]],
           "quality": [0, 0, 0, 0, 0], "part_of_gaussian": []})",
        R"("part_pixels": [1, 2, 3], "merges": [[0, 1, 2], [3, 2, 1]],
           "quality": [0, 0, 0, 0, 0], "part_of_gaussian": []})",
        R"("part_pixels": [1, -2], "merges": [],
           "quality": [0, 0], "part_of_gaussian": []})",
        R"("part_pixels": [1, 2], "merges": [],
           "quality": [0, 0], "part_of_gaussian": [2]})",
        R"("part_pixels": [1, 2], "merges": [],
           "quality": [0], "part_of_gaussian": []})",
        R"("part_pixels": [1, 2], "merges": [],
           "quality": [0, 1.5], "part_of_gaussian": []})",
        R"("part_pixels": [1], "merges": [[0, 0, 1], [0, 0, 1]],
           "quality": [0, 0, 0], "part_of_gaussian": []})",
        R"("part_pixels": {}, "merges": [],
           "quality": [], "part_of_gaussian": []})"}) {
    EXPECT_EQ(ParseHierarchy(head + rest).status().code(),
              StatusCode::kBadInput)
        << rest;
  }
}

}  // namespace
}  // namespace freegs::semantics
