// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/instances_json.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/temporary_folder.h"

namespace freegs::semantics {
namespace {

Instance MakeInstance(int id) {
  Instance instance;
  instance.id = id;
  instance.num_gaussians = 812;
  instance.centre = {0.1, -2, 3e-7};
  instance.aabb = {{-1, -2, -3}, {1, 2, 3}};
  instance.obb.centre = {1, 1, 1};
  instance.obb.size = {0.5, 0.25, 2};
  instance.obb.rotation << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  instance.score = 0.75;
  instance.background = id == 2;
  instance.words = {"red apple", "\xc3\xa4pfel \"quoted\""};
  return instance;
}

TEST(InstancesJsonTest, ComesBackAsWritten) {
  const TemporaryFolder folder;
  const std::string path = folder / "instances_json_test.json";
  ASSERT_TRUE(WriteInstances(path, {MakeInstance(1), MakeInstance(2)}).ok());
  const auto read = ReadInstances(path);
  ASSERT_TRUE(read.ok()) << read.status().message();
  ASSERT_EQ(read->size(), 2u);
  for (int i = 0; i < 2; ++i) {
    const Instance expected = MakeInstance(i + 1);
    const Instance& instance = (*read)[i];
    EXPECT_EQ(instance.id, expected.id);
    EXPECT_EQ(instance.num_gaussians, expected.num_gaussians);
    EXPECT_EQ(instance.centre, expected.centre);
    EXPECT_EQ(instance.aabb.min, expected.aabb.min);
    EXPECT_EQ(instance.aabb.max, expected.aabb.max);
    EXPECT_EQ(instance.obb.centre, expected.obb.centre);
    EXPECT_EQ(instance.obb.size, expected.obb.size);
    EXPECT_EQ(instance.obb.rotation, expected.obb.rotation);
    EXPECT_EQ(instance.score, expected.score);
    EXPECT_EQ(instance.background, expected.background);
    EXPECT_EQ(instance.words, expected.words);
  }
}

TEST(InstancesJsonTest, UsesTheDocumentedNames) {
  const auto json =
      nlohmann::json::parse(SerializeInstances({MakeInstance(1)}));
  for (const char* name :
       {"id", "num_gaussians", "centre", "aabb", "obb", "score", "words"}) {
    EXPECT_TRUE(json[0].contains(name)) << name;
  }
  // The second column of the rotation is the second side.
  EXPECT_EQ(json[0]["obb"]["rotation"][0][1], -1);
}

TEST(InstancesJsonTest, AnEmptyListIsFine) {
  const auto read = ParseInstances(SerializeInstances({}));
  ASSERT_TRUE(read.ok());
  EXPECT_TRUE(read->empty());
}

TEST(InstancesJsonTest, RefusesEveryTruncation) {
  std::string text = SerializeInstances({MakeInstance(1)});
  text.resize(text.find_last_of(']'));
  for (size_t size = 0; size < text.size(); ++size) {
    EXPECT_EQ(ParseInstances(text.substr(0, size)).status().code(),
              StatusCode::kBadInput);
  }
}

TEST(InstancesJsonTest, RefusesMissingAndMalformedMembers) {
  const auto good =
      nlohmann::json::parse(SerializeInstances({MakeInstance(1)}));
  for (const char* name :
       {"id", "num_gaussians", "centre", "aabb", "obb", "score"}) {
    auto bad = good;
    bad[0].erase(name);
    const auto read = ParseInstances(bad.dump());
    EXPECT_EQ(read.status().code(), StatusCode::kBadInput) << name;
    EXPECT_THAT(read.status().message(), testing::HasSubstr(name));
    for (const auto& wrong : {nlohmann::json("x"),
                              nlohmann::json::array({1, 2}),
                              nlohmann::json::object(),
                              nlohmann::json(nullptr),
                              nlohmann::json(-1e300)}) {
      if (std::string(name) == "score" && wrong.is_number()) continue;
      bad[0][name] = wrong;
      EXPECT_FALSE(ParseInstances(bad.dump()).ok()) << name << wrong;
    }
  }
  for (const char* text : {R"({"id": 1})", "[1]", "[[]]", "[null]", "7"}) {
    EXPECT_FALSE(ParseInstances(text).ok()) << text;
  }
  auto huge = good.dump();
  huge.replace(huge.find("812"), 3, "1e999");
  EXPECT_FALSE(ParseInstances(huge).ok());
}

TEST(InstancesJsonTest, RefusesRepeatedAndZeroIds) {
  EXPECT_FALSE(
      ParseInstances(SerializeInstances({MakeInstance(3), MakeInstance(3)}))
          .ok());
  EXPECT_FALSE(ParseInstances(SerializeInstances({MakeInstance(0)})).ok());
}

TEST(InstancesJsonTest, DeepNestingIsAnErrorNotACrash) {
  const TemporaryFolder folder;
  const std::string lists(1'000'000, '[');
  for (const std::string& text : {lists, lists + std::string(1'000'000, ']')}) {
    folder.Write("instances.json", text);
    const auto read = ReadInstances(folder / "instances.json");
    EXPECT_EQ(read.status().code(), StatusCode::kBadInput);
    EXPECT_THAT(read.status().message(),
                testing::HasSubstr("instances.json: nested deeper"));
  }
}

}  // namespace
}  // namespace freegs::semantics
