// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/region_quality.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

// Three squares of 10 x 10 pixels in a row, the last behind a crumb.
RegionGraph Row() {
  RegionGraph graph;
  for (const double pixels : {100.0, 100.0, 1.0, 100.0}) {
    RegionStats region;
    region.pixels = pixels;
    region.perimeter = 4 * std::sqrt(pixels);
    region.color = pixels * Eigen::Vector3d(0.5, 0.1, 0);
    region.color2 = pixels * Eigen::Vector3d(0.25 + 0.04, 0.01, 0);
    region.weight = 1;
    region.position = Eigen::Vector3d(1, 2, 3);
    region.position2 = region.position * region.position.transpose();
    region.position2(0, 0) += 4;
    region.position2(1, 1) += 1;
    graph.regions.push_back(region);
    graph.total_pixels += pixels;
  }
  for (const int32_t a : {0, 1, 2}) {
    ContactStats contact;
    contact.pixels = a == 0 ? 10 : 1;
    contact.contrast_far = a == 0 ? 2.5 : 0;
    graph.contacts.push_back({a, a + 1, contact});
  }
  return graph;
}

// {0, 1}, with the crumb, and all.
RegionTree Tree() {
  return {.num_leaves = 4, .merges = {{0, 1, -3}, {4, 2, -1}, {5, 3, 20}}};
}

// Log-odds are the bias.
EvidenceModel Model() {
  EvidenceModel model;
  model.deviation.fill(1);
  model.bias = 0.5;
  return model;
}

TEST(RegionQualityTest, MeasuresRegions) {
  std::vector<Evidence> evidence(3, Evidence{});
  for (size_t k = 0; k < evidence.size(); ++k) {
    evidence[k][kStep] = static_cast<float>(k + 1);
  }
  const std::vector<RegionAttributes> all = MeasureRegions(
      Row(), EvidenceOfContacts(Row()), Tree(), evidence, Model(), 10);
  ASSERT_EQ(all.size(), 7u);
  const RegionAttributes& leaf = all[0];
  EXPECT_FLOAT_EQ(leaf[kPartsHeight], -8);
  EXPECT_FLOAT_EQ(leaf[kNeighbourHeight], -3);
  EXPECT_NEAR(leaf[kRegionSize], std::log10(100 / 301.0), 1e-6);
  EXPECT_FLOAT_EQ(leaf[kNeighbourSize], 0);
  EXPECT_FLOAT_EQ(leaf[kLargestPart], 1);
  EXPECT_FLOAT_EQ(leaf[kOpenOutline], 0.75f);
  EXPECT_NEAR(leaf[kThinness], 0, 1e-6);
  EXPECT_FLOAT_EQ(leaf[kRoundness], 0.5f);
  EXPECT_NEAR(leaf[kRuggedness], std::log10(16), 1e-6);
  EXPECT_NEAR(leaf[kColorSpread], 0.2, 1e-6);
  // Region 5 differs from 4 by a crumb, which counts neither as a part nor as a
  // neighbour.
  for (const size_t r : {size_t{4}, size_t{5}}) {
    EXPECT_FLOAT_EQ(all[r][kPartsHeight], -3) << r;
    EXPECT_FLOAT_EQ(all[r][kNeighbourHeight], 8) << r;
    EXPECT_FLOAT_EQ(all[r][kLargestPart], 0.5f) << r;
    EXPECT_FLOAT_EQ(all[r][kOuterHeight], 8) << r;
    EXPECT_FLOAT_EQ(all[r][kFirstPartsAttribute + kStep], 1) << r;
    EXPECT_FLOAT_EQ(all[r][kFirstNeighbourAttribute + kStep], 3) << r;
  }
  EXPECT_FLOAT_EQ(leaf[kFirstOutlineAttribute + kContactOdds], 0.5f);
  EXPECT_FLOAT_EQ(leaf[kFirstOutlineAttribute + kContactFar], 0.25f);
  EXPECT_FLOAT_EQ(leaf[kFirstInsideAttribute + kContactFar], 0);
  EXPECT_FLOAT_EQ(all[4][kFirstOutlineAttribute + kContactFar], 0);
  EXPECT_FLOAT_EQ(all[4][kFirstInsideAttribute + kContactFar], 0.25f);
  EXPECT_NEAR(all[6][kFirstInsideAttribute + kContactFar], 2.5 / 12, 1e-6);
  // Two squares that share a side have an outline of 60 pixels.
  EXPECT_NEAR(all[4][kOpenOutline], 1 - 1 / 60.0, 1e-6);
  const RegionAttributes& root = all[6];
  EXPECT_FLOAT_EQ(root[kPartsHeight], 8);
  EXPECT_FLOAT_EQ(root[kNeighbourHeight], 8);
  EXPECT_FLOAT_EQ(root[kNeighbourSize], 3);
  EXPECT_FLOAT_EQ(root[kOpenOutline], 1);
  EXPECT_FLOAT_EQ(root[kFirstNeighbourAttribute + kStep], 0);
}

TEST(RegionQualityTest, AttributesAreFiniteWhereNothingIsKnown) {
  RegionGraph graph;
  graph.regions.resize(2);
  graph.contacts.push_back({0, 1, {}});
  const RegionTree tree = {.num_leaves = 2, .merges = {{0, 1, 1e308}}};
  for (const double min_size : {0.0, 10.0}) {
    for (const RegionAttributes& attributes :
         MeasureRegions(graph,
                        EvidenceOfContacts(graph),
                        tree,
                        std::vector<Evidence>(1),
                        Model(),
                        min_size)) {
      for (const float attribute : attributes)
        EXPECT_TRUE(std::isfinite(attribute));
    }
  }
}

std::string QualityText(const std::string& last_name, const std::string& most) {
  std::string text = R"({"bias": -1, "numbers": [)";
  for (size_t k = 0; k < kNumRegionAttributes; ++k) {
    const bool last = k + 1 == kNumRegionAttributes;
    text += R"({"name": ")" + (last ? last_name : RegionAttributeName(k)) +
            R"(", "least": -8, "most": )" + (last ? most : "8") +
            R"(, "weight": )" + (k == 0 ? "3" : "0") + "}" +
            (last ? "]}" : ",");
  }
  return text;
}

const std::string kLast = "neighbour.off_plane";

TEST(RegionQualityTest, AttributesCountWithinWhatWasSeen) {
  const auto model = ParseQualityModel(QualityText(kLast, "8"));
  ASSERT_TRUE(model.ok()) << model.status().message();
  RegionAttributes attributes = {};
  const auto probability = [&](float height) {
    attributes[kPartsHeight] = height;
    return model->Probability(attributes);
  };
  EXPECT_NEAR(probability(0), 1 / (1 + std::exp(-0.5)), 1e-9);
  EXPECT_NEAR(probability(-8), 1 / (1 + std::exp(1.0)), 1e-9);
  EXPECT_EQ(probability(-80), probability(-8));
  EXPECT_EQ(probability(80), probability(8));
}

TEST(RegionQualityTest, TheOneThatShipsIsReadable) {
  const auto model = DefaultQualityModel();
  ASSERT_TRUE(model.ok()) << model.status().message();
  const double probability = model->Probability({});
  EXPECT_GT(probability, 0);
  EXPECT_LT(probability, 1);
}

TEST(RegionQualityTest, RefusesDamagedFiles) {
  for (const std::string& text : {std::string(),
                                  std::string("{}"),
                                  std::string("[1, 2]"),
                                  std::string(R"({"bias": 1, "numbers": []})"),
                                  QualityText("smell", "8"),
                                  QualityText("parts_height", "8"),
                                  QualityText(kLast, "-9"),
                                  QualityText(kLast, "1e400"),
                                  QualityText(kLast, "\"2\"")}) {
    EXPECT_EQ(ParseQualityModel(text).status().code(), StatusCode::kBadInput)
        << text;
  }
  const std::string whole = QualityText(kLast, "8");
  for (size_t length = 0; length < whole.size(); length += 97) {
    EXPECT_FALSE(ParseQualityModel(whole.substr(0, length)).ok());
  }
}

}  // namespace
}  // namespace freegs::semantics
