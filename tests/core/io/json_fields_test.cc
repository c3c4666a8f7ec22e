// SPDX-License-Identifier: BSD-3-Clause
// Readers of JSON, with files that are damaged or made to do harm.

#include "core/io/json_fields.h"

#include <climits>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/random.h"

namespace freegs {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::StartsWith;

constexpr size_t kMillion = 1'000'000;

constexpr char kGood[] =
    R"({"name": "a", "size": 3, "rows": [[1, 2.5], [3, -4e2]], "none": null})";

// The message of a fault, which must be kBadInput; "" when there is none.
template <typename T>
std::string Fault(const StatusOr<T>& result) {
  if (result.ok()) return "";
  EXPECT_EQ(result.status().code(), StatusCode::kBadInput);
  return result.status().message();
}

TEST(ParseJsonTest, ReadsADocument) {
  const auto document = ParseJson(kGood, "a.json");
  ASSERT_TRUE(document.ok()) << document.status().message();
  EXPECT_EQ(*document, json::parse(kGood));
  EXPECT_TRUE(ParseJson("7").ok());
  EXPECT_EQ(Fault(ParseJsonObject("7", "a.json")),
            "a.json: the top level must be an object");
  EXPECT_EQ(Fault(ParseJsonObject("7")), "the top level must be an object");
}

TEST(ParseJsonTest, TruncatedTextIsAFault) {
  const std::string good = kGood;
  for (size_t size = 0; size < good.size(); ++size) {
    EXPECT_EQ(Fault(ParseJson(good.substr(0, size), "a.json")),
              "a.json: not valid JSON")
        << size;
  }
}

TEST(ParseJsonTest, SurvivesChangedBytes) {
  const std::string good = kGood;
  int refused = 0;
  for (uint64_t trial = 0; trial < 2000; ++trial) {
    std::string text = good;
    text[RandomIndex(5, trial, 0, text.size())] =
        static_cast<char>(RandomBits(5, trial, 1));
    const auto document = ParseJson(text, "a.json");
    if (document.ok()) continue;
    EXPECT_THAT(Fault(document), StartsWith("a.json: ")) << text;
    ++refused;
  }
  EXPECT_GT(refused, 0);
}

TEST(ParseJsonTest, DeepNestingIsAFaultAndNoCrash) {
  const std::string lists(kMillion, '[');
  EXPECT_THAT(Fault(ParseJson(lists, "a.json")),
              HasSubstr("a.json: nested deeper than 64 levels"));
  EXPECT_THAT(Fault(ParseJson(lists + std::string(kMillion, ']'), "a.json")),
              HasSubstr("nested deeper"));
  std::string objects;
  for (size_t i = 0; i < kMillion; ++i) objects += "{\"a\":";
  EXPECT_THAT(Fault(ParseJson(objects, "a.json")), HasSubstr("nested deeper"));
  EXPECT_THAT(Fault(ParseJson(R"({"x": )" + lists + "}", "a.json")),
              HasSubstr("nested deeper"));
}

TEST(ParseJsonTest, NestingUpToTheLimitIsRead) {
  const auto nested = [](int depth) {
    const auto count = static_cast<size_t>(depth);
    return std::string(count, '[') + std::string(count, ']');
  };
  EXPECT_TRUE(ParseJson(nested(kMaxJsonDepth)).ok());
  EXPECT_FALSE(ParseJson(nested(kMaxJsonDepth + 2)).ok());
}

TEST(ReadFieldTest, NumbersHaveTheirKindAndRange) {
  const json three = 3;
  const json real = 3.5;
  const json text = "3";
  const json large = uint64_t{1} << 63;
  EXPECT_EQ(*ReadNumber(&real, "x"), 3.5);
  EXPECT_EQ(Fault(ReadNumber(&text, "a: x")), "a: x: must be a finite number");
  EXPECT_EQ(Fault(ReadNumber(nullptr, "a: x")), "a: x: is missing");
  EXPECT_EQ(Fault(ReadNumber(&real, 0, 2, "x")), "x: must be a number in 0..2");
  EXPECT_EQ(Fault(ReadNumber(&large, -1, 1e12, "x")),
            "x: must be a number in -1..1e+12");
  EXPECT_EQ(*ReadInteger(&three, 3, 3, "x"), 3);
  const json whole = 3.0;
  EXPECT_EQ(*ReadInteger(&whole, 0, 9, "x"), 3);
  for (const json* wrong : {&real, &text, &large}) {
    EXPECT_EQ(Fault(ReadInteger(wrong, INT_MIN, INT_MAX, "x")),
              "x: must be a whole number in -2147483648..2147483647");
  }
  const json huge = 1e300;
  EXPECT_FALSE(ReadInteger64(&huge, INT64_MIN, INT64_MAX, "x").ok());
  EXPECT_FALSE(ReadInteger64(&large, INT64_MIN, INT64_MAX, "x").ok());
  const json exact = INT64_MAX;
  EXPECT_EQ(*ReadInteger64(&exact, 0, INT64_MAX, "x"), INT64_MAX);
}

TEST(ReadFieldTest, TextsAndFlags) {
  const json text = "a";
  const json flag = true;
  EXPECT_EQ(*ReadText(&text, "x"), "a");
  EXPECT_EQ(Fault(ReadText(&flag, "x")), "x: must be a text");
  EXPECT_EQ(*ReadBool(&flag, "x"), true);
  EXPECT_EQ(Fault(ReadBool(&text, "x")), "x: must be true or false");
  EXPECT_EQ(FindField(text, "x"), nullptr);
}

TEST(ReadFieldTest, VectorsAndMatrices) {
  const json vector = {1, 2, 3};
  EXPECT_EQ(*ReadVector3(&vector, "x"), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(VectorJson(Eigen::Vector3d(1, 2, 3)), vector);
  EXPECT_EQ(OrNull(2.5), json(2.5));
  EXPECT_TRUE(OrNull(std::nullopt).is_null());
  const json matrix = {{1, 2, 3}, {4, 5, 6}};
  const auto read = ReadMatrix(&matrix, 2, 3, "x");
  ASSERT_TRUE(read.ok());
  EXPECT_EQ((*read)(1, 2), 6);
  for (const char* text :
       {"7", "[]", "[1, 2]", "[1, 2, 3, 4]", "[1, 2, null]", "{}"}) {
    const json wrong = json::parse(text);
    EXPECT_FALSE(ReadVector3(&wrong, "x").ok()) << text;
    EXPECT_FALSE(ReadMatrix(&wrong, 2, 3, "x").ok()) << text;
  }
  EXPECT_EQ(Fault(ReadMatrix(&matrix, 3, 3, "x")),
            "x: must be 3 rows of 3 numbers");
  EXPECT_TRUE(CheckRotation(Eigen::Matrix3d::Identity(), "x").ok());
  EXPECT_FALSE(CheckRotation(-Eigen::Matrix3d::Identity(), "x").ok());
  EXPECT_FALSE(CheckRotation(1.01 * Eigen::Matrix3d::Identity(), "x").ok());
  EXPECT_TRUE(CheckRotation(1.01 * Eigen::Matrix3d::Identity(), "x", 0.1).ok());
  for (int entry = 0; entry < 9; ++entry) {
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
    matrix(entry / 3, entry % 3) = std::nan("");
    EXPECT_FALSE(CheckRotation(matrix, "x").ok()) << entry;
  }
  EXPECT_FALSE(
      CheckRotation(Eigen::Matrix3d::Constant(std::nan("")), "x").ok());
}

TEST(JsonObjectReaderTest, ReadsEveryKind) {
  const json object = json::parse(
      R"({"n": 2.5, "i": 4, "b": true, "t": "a", "v": [1, 2, 3],
          "m": [[1, 2]], "map": {"k": "w"}, "l": [1], "none": null,
          "words": ["a", "b"]})");
  Status status;
  JsonObjectReader reader(object, "a.json", "x[0]", &status);
  EXPECT_EQ(reader.Number("n", 0, 3), 2.5);
  EXPECT_EQ(reader.Integer("i", 0, 9), 4);
  EXPECT_EQ(reader.Integer64("i", 0, 9), 4);
  EXPECT_TRUE(reader.Bool("b"));
  EXPECT_EQ(reader.Text("t"), "a");
  EXPECT_EQ(reader.Vector3("v"), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(reader.Matrix("m", 1, 2)(0, 1), 2);
  EXPECT_EQ(reader.TextMap("map").at("k"), "w");
  EXPECT_EQ(reader.TextList("words"), std::vector<std::string>({"a", "b"}));
  EXPECT_EQ(reader.List("l").size(), 1u);
  EXPECT_TRUE(reader.Object("map").is_object());
  EXPECT_TRUE(reader.IsNull("none"));
  EXPECT_FALSE(reader.Has("absent"));
  EXPECT_TRUE(status.ok()) << status.message();
}

TEST(JsonObjectReaderTest, TheFirstFaultStays) {
  const json object = {{"n", 2}, {"t", 7}};
  Status status;
  JsonObjectReader reader(object, "a.json", "x[0]", &status);
  EXPECT_EQ(reader.Text("t"), "");
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_EQ(status.message(), "a.json: x[0].t: must be a text");
  // Nothing is read after a fault, and no other fault takes its place.
  EXPECT_EQ(reader.Integer("n", 0, 9), 0);
  EXPECT_TRUE(reader.List("absent").empty());
  reader.Fail("n", "is odd");
  JsonObjectReader other(object, "", "", &status);
  EXPECT_EQ(other.Integer("n", 0, 9), 0);
  EXPECT_EQ(status.message(), "a.json: x[0].t: must be a text");
}

TEST(JsonObjectReaderTest, FaultsAreNamed) {
  const json object =
      json::parse(R"({"map": {"k": 1}, "l": {}, "words": ["a", 1]})");
  const auto fault = [&object](const auto& read) {
    Status status;
    JsonObjectReader reader(object, "a.json", "", &status);
    read(reader);
    return status.message();
  };
  EXPECT_EQ(fault([](auto& r) { r.TextMap("map"); }),
            "a.json: map.k: must be a text");
  EXPECT_EQ(fault([](auto& r) { r.TextList("words"); }),
            "a.json: words[1]: must be a text");
  EXPECT_EQ(fault([](auto& r) { r.List("l"); }), "a.json: l: must be a list");
  EXPECT_EQ(fault([](auto& r) { r.Object("o"); }), "a.json: o: is missing");
  Status status;
  const json list = json::array();
  JsonObjectReader reader(list, "", "entry 3", &status);
  EXPECT_EQ(status.message(), "entry 3: must be an object");
}

}  // namespace
}  // namespace freegs
