// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/named_wholes.h"

#include <gtest/gtest.h>

#include "tests/semantics/clip/color_encoder.h"

namespace freegs::semantics {
namespace {

InstanceVectors VectorsOf(const std::vector<std::array<double, 3>>& colors) {
  InstanceVectors vectors{.dim = 8};
  for (const auto& color : colors) {
    const std::vector<float> vector = ColorEncoder::Embed(color);
    vectors.vectors.insert(vectors.vectors.end(), vector.begin(), vector.end());
  }
  return vectors;
}

constexpr std::array<double, 3> kRed = {0.8, 0.1, 0.1};
constexpr std::array<double, 3> kReddish = {0.6, 0.4, 0.4};
constexpr std::array<double, 3> kBluish = {0.4, 0.4, 0.6};
constexpr std::array<double, 3> kGrey = {0.5, 0.5, 0.5};

StatusOr<KnownThings> RedAndBlue(double min_confidence) {
  ColorEncoder encoder;
  KnownThings things{.vocabulary = {}, .min_confidence = min_confidence};
  FREEGS_ASSIGN_OR_RETURN(things.vocabulary,
                          Vocabulary::Create({{"red", "blue"}}, encoder));
  return things;
}

TEST(NamedWholesTest, WhatIsTheSameThingTogetherAndMoreSurely) {
  const auto things = RedAndBlue(0.7);
  ASSERT_TRUE(things.ok());
  EXPECT_TRUE(things->have_say());
  const InstanceVectors alone = VectorsOf({kReddish, kGrey, kRed, kBluish});
  // The second pair is as red as one of its parts, the third is grey, and the
  // fourth is red although neither part is.
  const std::vector<InstancePair> pairs = {{0, 1}, {0, 2}, {1, 2}, {1, 3}};
  const InstanceVectors together = VectorsOf({kRed, kRed, kGrey, kRed});
  const auto wholes = FindNamedWholes(pairs, alone, together, *things);
  ASSERT_EQ(wholes.size(), 1u);
  EXPECT_EQ(wholes[0].pair, (InstancePair{0, 1}));
  EXPECT_GE(wholes[0].confidence, 0.7);

  const auto unsure = RedAndBlue(1);
  ASSERT_TRUE(unsure.ok());
  EXPECT_TRUE(FindNamedWholes(pairs, alone, together, *unsure).empty());
}

TEST(NamedWholesTest, WhoKnowsNoThingsHasNoSay) {
  EXPECT_FALSE(KnownThings().have_say());
  const auto things = RedAndBlue(0);
  ASSERT_TRUE(things.ok());
  EXPECT_FALSE(things->have_say());
}

}  // namespace
}  // namespace freegs::semantics
