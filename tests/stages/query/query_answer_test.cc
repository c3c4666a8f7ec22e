// SPDX-License-Identifier: BSD-3-Clause

#include "stages/query/query_answer.h"

#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

QueryAnswer MakeAnswer(int max_hits, double threshold) {
  QueryAnswer answer;
  answer.question = {{"kind", "text"}, {"text", "a \"cup\""}};
  answer.words = "text \"cup\"";
  answer.score_name = "relevancy";
  answer.threshold = threshold;
  std::vector<ScoredInstance> scored;
  for (int id = 1; id <= 9; ++id) {
    scored.push_back({id, 0.9 - 0.1 * id, 0.3, {}});
  }
  SplitHits(scored, max_hits, &answer);
  return answer;
}

std::vector<semantics::Instance> Instances() {
  std::vector<semantics::Instance> instances;
  for (int id = 1; id <= 9; ++id) {
    semantics::Instance instance;
    instance.id = id;
    instance.score = 0.25;
    instance.words = {"cup", "blue"};
    instances.push_back(instance);
  }
  return instances;
}

TEST(QueryAnswerTest, HitsPassTheThresholdAndOthersFollow) {
  EXPECT_EQ(MakeAnswer(1, 0.45).hits.size(), 1u);
  EXPECT_EQ(MakeAnswer(0, 0.45).hits.size(), 4u);
  EXPECT_EQ(MakeAnswer(7, 0.45).hits.size(), 4u);
  const QueryAnswer none = MakeAnswer(0, 0.95);
  EXPECT_TRUE(none.hits.empty());
  EXPECT_EQ(none.others.size(), 5u);
  EXPECT_EQ(none.others[0].id, 1);
  QueryAnswer empty;
  SplitHits({}, 1, &empty);
  EXPECT_TRUE(empty.hits.empty());
  EXPECT_TRUE(empty.others.empty());
}

TEST(QueryAnswerTest, JsonHasTheDocumentedNames) {
  QueryAnswer answer = MakeAnswer(2, 0.45);
  answer.hits[0].point = Eigen::Vector3d(1, 2, 3);
  answer.masks = {{"a.jpg", "masks/a.png", 7}};
  answer.plane = ScoredInstance{9, 0.99, 0.4, {}};
  const nlohmann::json json = ToJson(answer, Instances());
  EXPECT_EQ(json["query"]["text"], "a \"cup\"");
  EXPECT_EQ(json["found"], true);
  EXPECT_EQ(json["score"], "relevancy");
  EXPECT_EQ(json["threshold"], 0.45);
  EXPECT_EQ(json["best_score"], 0.8);
  ASSERT_EQ(json["hits"].size(), 2u);
  for (const char* name : {"id",
                           "score",
                           "cosine",
                           "instance_score",
                           "num_gaussians",
                           "centre",
                           "aabb",
                           "obb",
                           "background",
                           "words"}) {
    EXPECT_TRUE(json["hits"][0].contains(name)) << name;
  }
  EXPECT_EQ(json["hits"][0]["score"], 0.8);
  EXPECT_EQ(json["hits"][0]["instance_score"], 0.25);
  EXPECT_EQ(json["hits"][0]["point"][2], 3);
  EXPECT_EQ(json["others"][0]["id"], 3);
  EXPECT_EQ(json["plane"]["id"], 9);
  EXPECT_EQ(json["note"], "");
  EXPECT_EQ(json["masks"][0]["pixels"], 7);
  for (const char* name : {"load_ms", "encode_ms", "query_ms", "masks_ms"}) {
    EXPECT_TRUE(json["timings"].contains(name)) << name;
  }
}

TEST(QueryAnswerTest, JsonKeepsTheDoubtsAndTheBestOfAllScores) {
  QueryAnswer answer = MakeAnswer(1, 0.45);
  answer.note = "query: this is a guess\n";
  // A part of what was clicked may weigh less than another instance.
  answer.hits[0].score = 0.1;
  const nlohmann::json json = ToJson(answer, Instances());
  EXPECT_EQ(json["note"], "query: this is a guess\n");
  EXPECT_EQ(json["best_score"], answer.others[0].score);
}

TEST(QueryAnswerTest, NothingFoundIsSaidPlainly) {
  const QueryAnswer answer = MakeAnswer(1, 0.95);
  const nlohmann::json json = ToJson(answer, Instances());
  EXPECT_EQ(json["found"], false);
  EXPECT_TRUE(json["hits"].empty());
  EXPECT_EQ(json["best_score"], 0.8);
  EXPECT_FALSE(json.contains("masks"));
  std::ostringstream text;
  PrintAnswer(answer, Instances(), text);
  EXPECT_THAT(text.str(),
              AllOf(HasSubstr("not found: text \"cup\""),
                    HasSubstr("instance 1 with relevancy 0.800"),
                    HasSubstr("less than 0.950")));
  // A score that is barely missed does not look like the threshold.
  std::ostringstream barely;
  PrintAnswer(MakeAnswer(1, 0.8003), Instances(), barely);
  EXPECT_THAT(barely.str(), HasSubstr("relevancy 0.8000, less than 0.8003"));
  QueryAnswer with_plane = answer;
  const auto advice = [&with_plane](double score) {
    with_plane.plane = ScoredInstance{9, score, 0.4, {}};
    std::ostringstream said;
    PrintAnswer(with_plane, Instances(), said);
    return said.str();
  };
  EXPECT_THAT(advice(0.96), HasSubstr("--background"));
  EXPECT_THAT(advice(0.94), Not(HasSubstr("--background")));
  QueryAnswer empty;
  empty.words = "click a 1 2";
  EXPECT_TRUE(ToJson(empty, {})["best_score"].is_null());
  std::ostringstream nothing;
  PrintAnswer(empty, {}, nothing);
  EXPECT_EQ(nothing.str(), "not found: click a 1 2\n");
}

TEST(QueryAnswerTest, TheTableNamesHitsAndTheNext) {
  std::ostringstream text;
  PrintAnswer(MakeAnswer(1, 0.5), Instances(), text);
  EXPECT_THAT(text.str(),
              AllOf(HasSubstr("found: text \"cup\""),
                    HasSubstr("0.800"),
                    HasSubstr("cup, blue"),
                    HasSubstr("next: 2 (0.700), 3 (0.600)")));
}

TEST(QueryAnswerTest, TheTableFitsSmallUnitsAndFarScenes) {
  std::vector<semantics::Instance> instances = Instances();
  instances[0].num_gaussians = 1234;
  instances[0].centre = {-512345.678, 5712345.25, 41.5};
  instances[0].obb.size = {0.5, 0.25, 0.125};
  instances[1].centre = {0.0000123, -0.00002, 0};
  instances[1].obb.size = {0.00002, 0.00001, 0.000004};
  instances[2].centre = {-1203.4, 77, 0};
  instances[2].obb.size = {350.4, 20, 3};
  instances[2].background = true;
  std::ostringstream text;
  PrintAnswer(MakeAnswer(3, 0.5), instances, text);
  EXPECT_THAT(
      text.str(),
      HasSubstr("  id  relevancy  Gaussians  centre                          "
                "size of oriented box           words\n"
                "   1      0.800       1234  -512345.678 5712345.250 41.500  "
                "0.500 0.250 0.125              cup, blue\n"
                "   2      0.700          0  0.0000123 -0.0000200 0.0000000  "
                "0.0000200 0.0000100 0.0000040  cup, blue\n"
                "   3      0.600          0  -1203 77 0                      "
                "350 20 3                       cup, blue (large plane)\n"));
}

}  // namespace
}  // namespace freegs::stages
