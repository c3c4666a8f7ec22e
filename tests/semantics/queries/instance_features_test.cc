// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/queries/instance_features.h"

#include <cmath>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/temporary_folder.h"

namespace freegs::semantics {
namespace {

using nlohmann::json;
using testing::HasSubstr;

InstanceFeatures MakeFeatures() {
  const float third = std::sqrt(1.0f / 3);
  return {.dim = 3,
          .model = "models/small \"clip\"",
          .model_hash = "00ff",
          .features = {0.6f, -0.8f, 0, 0, 0, 0, third, third, third}};
}

TEST(InstanceFeaturesTest, ComesBackAsWritten) {
  const TemporaryFolder folder;
  const std::string path = folder / "instance_features_test.json";
  const InstanceFeatures expected = MakeFeatures();
  ASSERT_TRUE(WriteInstanceFeatures(path, expected).ok());
  const auto read = ReadInstanceFeatures(path);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->dim, expected.dim);
  EXPECT_EQ(read->model, expected.model);
  EXPECT_EQ(read->model_hash, expected.model_hash);
  EXPECT_EQ(read->features, expected.features);
  ASSERT_EQ(read->size(), 3u);
  EXPECT_TRUE(read->known(0));
  EXPECT_FALSE(read->known(1));
  EXPECT_EQ(read->row(0)[1], -0.8f);
}

TEST(InstanceFeaturesTest, NoInstancesAreFine) {
  InstanceFeatures none;
  none.dim = 4;
  const auto text = SerializeInstanceFeatures(none);
  ASSERT_TRUE(text.ok());
  const auto read = ParseInstanceFeatures(*text);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->size(), 0u);
  EXPECT_EQ(InstanceFeatures().size(), 0u);
}

TEST(InstanceFeaturesTest, RefusesToWriteWhatItWouldNotRead) {
  InstanceFeatures bad = MakeFeatures();
  bad.features.pop_back();
  EXPECT_EQ(SerializeInstanceFeatures(bad).status().code(),
            StatusCode::kInvalidArgument);
  bad = MakeFeatures();
  bad.dim = 0;
  EXPECT_FALSE(SerializeInstanceFeatures(bad).ok());
  for (const float value : {std::numeric_limits<float>::quiet_NaN(),
                            std::numeric_limits<float>::infinity(),
                            2.0f}) {
    bad = MakeFeatures();
    bad.features[4] = value;
    EXPECT_EQ(SerializeInstanceFeatures(bad).status().code(),
              StatusCode::kInvalidArgument);
  }
}

TEST(InstanceFeaturesTest, RefusesEveryTruncation) {
  std::string text = *SerializeInstanceFeatures(MakeFeatures());
  text.resize(text.find_last_of('}'));
  for (size_t size = 0; size < text.size(); ++size) {
    EXPECT_EQ(ParseInstanceFeatures(text.substr(0, size)).status().code(),
              StatusCode::kBadInput);
  }
}

TEST(InstanceFeaturesTest, RefusesMissingAndMalformedMembers) {
  const json good = json::parse(*SerializeInstanceFeatures(MakeFeatures()));
  for (const char* name : {"model", "model_hash", "dim", "features"}) {
    json bad = good;
    bad.erase(name);
    const auto read = ParseInstanceFeatures(bad.dump());
    EXPECT_EQ(read.status().code(), StatusCode::kBadInput) << name;
    EXPECT_THAT(read.status().message(), HasSubstr(name));
    for (const json& wrong : {json(nullptr),
                              json(-1),
                              json(1.5),
                              json(uint64_t{1} << 63),
                              json::array({1, 2}),
                              json::object({{"a", 1}})}) {
      bad[name] = wrong;
      EXPECT_EQ(ParseInstanceFeatures(bad.dump()).status().code(),
                StatusCode::kBadInput)
          << name << wrong;
    }
  }
  for (const char* text : {"", "7", "[]", "null", "{}", "\xff\xfe"}) {
    EXPECT_FALSE(ParseInstanceFeatures(text).ok()) << text;
  }
}

TEST(InstanceFeaturesTest, RefusesBadRowsByTheIdOfTheirInstance) {
  const json good = json::parse(*SerializeInstanceFeatures(MakeFeatures()));
  for (const json& wrong : {json(1),
                            json::array(),
                            json::array({1, 0}),
                            json::array({1, 0, 0, 0}),
                            json::array({1, 0, nullptr}),
                            json::array({1, 0, "x"}),
                            json::array({1, 0, json::array()}),
                            json::array({1, 1, 0}),
                            json::array({1, 0, 1e300})}) {
    json bad = good;
    bad["features"][1] = wrong;
    const auto read = ParseInstanceFeatures(bad.dump());
    EXPECT_EQ(read.status().code(), StatusCode::kBadInput) << wrong;
    EXPECT_THAT(read.status().message(), HasSubstr("instance 2")) << wrong;
  }
  // A dimension that the rows do not have costs no memory.
  json bad = good;
  bad["dim"] = 65536;
  EXPECT_FALSE(ParseInstanceFeatures(bad.dump()).ok());
}

TEST(InstanceFeaturesTest, HugeNumbersAndDeepNestingAreErrors) {
  std::string text = *SerializeInstanceFeatures(MakeFeatures());
  text.replace(text.find("0.60"), 3, "1e999");
  EXPECT_FALSE(ParseInstanceFeatures(text).ok());
  EXPECT_FALSE(ParseInstanceFeatures(std::string(100000, '[')).ok());
  EXPECT_FALSE(ParseInstanceFeatures(
                   R"({"model": "", "model_hash": "", "dim": 1, "features": )" +
                   std::string(20000, '[') + std::string(20000, ']') + "}")
                   .ok());
}

TEST(InstanceFeaturesTest, ErrorsNameTheFile) {
  const TemporaryFolder folder;
  const auto missing = ReadInstanceFeatures(folder / "no_such_features.json");
  EXPECT_EQ(missing.status().code(), StatusCode::kBadInput);
  EXPECT_THAT(missing.status().message(), HasSubstr("no_such_features"));
}

}  // namespace
}  // namespace freegs::semantics
