// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/queries/text_query.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

using testing::ElementsAre;

// Instances along x, between x and y, along y; unknown; along x again.
InstanceFeatures MakeQueryFeatures() {
  const float half = std::sqrt(0.5f);
  return {.dim = 2,
          .model = "",
          .model_hash = "",
          .features = {1, 0, half, half, 0, 1, 0, 0, 1, 0}};
}

const std::vector<float> kX = {1, 0};
const std::vector<float> kY = {0, 1};

template <typename Hit>
std::vector<int> Ids(const StatusOr<std::vector<Hit>>& hits) {
  EXPECT_TRUE(hits.ok()) << hits.status().message();
  std::vector<int> ids;
  for (const Hit& hit : *hits) ids.push_back(hit.id);
  return ids;
}

TEST(TextQueryTest, BestFirstAndEqualsById) {
  TextQueryOptions options;
  options.min_relevancy = 0;
  const auto hits = QueryText(MakeQueryFeatures(), kX, kY, options);
  EXPECT_THAT(Ids(hits), ElementsAre(1, 5, 2, 3));
  EXPECT_NEAR((*hits)[0].relevancy, 1 / (1 + std::exp(-10)), 1e-6);
  EXPECT_NEAR((*hits)[2].relevancy, 0.5, 1e-6);
  EXPECT_NEAR((*hits)[0].cosine, 1, 1e-6);
  EXPECT_NEAR((*hits)[2].cosine, std::sqrt(0.5), 1e-6);
  EXPECT_NEAR((*hits)[3].cosine, 0, 1e-6);
}

TEST(TextQueryTest, WhatIsNoMoreLikeTheTextThanLikeAnyThingIsNotHere) {
  TextQueryOptions options;
  EXPECT_THAT(Ids(QueryText(MakeQueryFeatures(), kY, kX, options)),
              ElementsAre(3, 2));
  const std::vector<float> away = {-1, 0};
  std::vector<float> canonical = kY;
  canonical.insert(canonical.end(), kX.begin(), kX.end());
  EXPECT_THAT(Ids(QueryText(MakeQueryFeatures(), away, canonical, options)),
              ElementsAre());
}

TEST(TextQueryTest, LimitsAndBackground) {
  TextQueryOptions options;
  options.min_relevancy = 0;
  options.max_hits = 2;
  const std::vector<uint8_t> background = {1, 0, 0, 0, 0};
  EXPECT_THAT(Ids(QueryText(MakeQueryFeatures(), kX, kY, options, background)),
              ElementsAre(5, 2));
  options.background = true;
  EXPECT_THAT(Ids(QueryText(MakeQueryFeatures(), kX, kY, options, background)),
              ElementsAre(1, 5));
}

TEST(TextQueryTest, ExamplesGoByCosine) {
  ExampleQueryOptions options;
  const std::vector<float> image = {0, 7};  // Length does not matter.
  const auto hits = QueryExample(MakeQueryFeatures(), image, options);
  EXPECT_THAT(Ids(hits), ElementsAre(3, 2, 1, 5));
  EXPECT_NEAR((*hits)[0].cosine, 1, 1e-6);
  options.max_hits = 2;
  EXPECT_THAT(Ids(QueryExample(MakeQueryFeatures(), image, options)),
              ElementsAre(3, 2));
  options.max_hits = 0;
  const std::vector<uint8_t> background = {0, 0, 1, 0, 0};
  EXPECT_THAT(
      Ids(QueryExample(MakeQueryFeatures(), image, options, background)),
      ElementsAre(2, 1, 5));
}

TEST(TextQueryTest, NoInstancesNoHits) {
  InstanceFeatures none;
  none.dim = 2;
  EXPECT_THAT(Ids(QueryText(none, kX, kY, TextQueryOptions())), ElementsAre());
  EXPECT_THAT(Ids(QueryExample(none, kX, ExampleQueryOptions())),
              ElementsAre());
}

TEST(TextQueryTest, RefusesSizesThatDisagreeAndWhatIsNotFinite) {
  const InstanceFeatures features = MakeQueryFeatures();
  const TextQueryOptions options;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const std::vector<float>& wrong :
       {std::vector<float>{}, {1}, {1, 0, 0}, {1, 0, 0, 1}, {nan, 0}, {0, 0}}) {
    EXPECT_EQ(QueryText(features, wrong, kY, options).status().code(),
              StatusCode::kInvalidArgument);
    EXPECT_EQ(
        QueryExample(features, wrong, ExampleQueryOptions()).status().code(),
        StatusCode::kInvalidArgument);
  }
  for (const std::vector<float>& wrong :
       {std::vector<float>{1}, {1, 0, 0}, {nan, 0}}) {
    EXPECT_FALSE(QueryText(features, kX, wrong, options).ok());
  }
  EXPECT_FALSE(
      QueryText(features, kX, kY, options, std::vector<uint8_t>(4)).ok());
  EXPECT_FALSE(QueryText(InstanceFeatures(), kX, kY, options).ok());
}

TEST(TextQueryTest, OptionsHaveRanges) {
  TextQueryOptions text;
  text.min_relevancy = 1.5;
  EXPECT_FALSE(QueryText(MakeQueryFeatures(), kX, kY, text).ok());
  text.min_relevancy = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(text.Check().ok());
  text = TextQueryOptions();
  text.max_hits = -1;
  EXPECT_FALSE(text.Check().ok());
  ExampleQueryOptions example;
  example.max_hits = -1;
  EXPECT_FALSE(QueryExample(MakeQueryFeatures(), kX, example).ok());
}

}  // namespace
}  // namespace freegs::semantics
