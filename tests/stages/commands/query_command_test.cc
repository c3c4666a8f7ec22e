// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/query_command.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/image_io.h"
#include "pipeline/stage_record.h"
#include "semantics/clip/opencv_clip.h"
#include "semantics/instances/instances_json.h"
#include "semantics/queries/instance_features.h"
#include "tests/semantics/clip/model_files.h"
#include "tests/stages/commands/query_fixture.h"

namespace freegs::stages {
namespace {

using semantics::ModelCopy;
using semantics::TinyClip;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr char kMissing[] = "run stage bootstrap";

using QueryCommandTest = QueryFixture;

TEST_F(QueryCommandTest, TextFindsTheInstanceThatMeansIt) {
  AddFeatures();
  const nlohmann::json answer = QueryJson({"--text", "red apple"});
  EXPECT_EQ(answer["found"], true);
  ASSERT_EQ(answer["hits"].size(), 1u);
  EXPECT_EQ(answer["hits"][0]["id"], 1);
  EXPECT_NEAR(answer["hits"][0]["cosine"].get<double>(), 1, 1e-5);
  EXPECT_GT(answer["hits"][0]["score"].get<double>(), 0.5);
  EXPECT_EQ(answer["hits"][0]["num_gaussians"],
            workspace_.instances[0].num_gaussians);
  ASSERT_EQ(answer["others"].size(), 1u);
  EXPECT_EQ(answer["others"][0]["id"], 2);
  EXPECT_GT(answer["timings"]["encode_ms"].get<double>(), 0);

  ASSERT_EQ(Query({"--text", "wooden box"}), 0) << message_;
  EXPECT_THAT(
      output_.str(),
      AllOf(HasSubstr("found: text \"wooden box\""), HasSubstr("next: 1")));
}

TEST_F(QueryCommandTest, SaysWhenTheModelDoesNotKnowTheAnswer) {
  AddFeatures();
  const ModelCopy model;
  const std::vector<std::string> question = {
      "--text", "red apple", "--model", model.path().string()};
  // A model without a threshold has no opinion on what it knows.
  ASSERT_EQ(Query(question), 0) << message_;
  EXPECT_EQ(messages_.str(), "");
  nlohmann::json info = model.Info();
  info["min_word_confidence"] = 0.75;
  model.SetInfo(info);
  ASSERT_EQ(Query(question), 0) << message_;
  EXPECT_THAT(output_.str(), HasSubstr("found: text \"red apple\""));
  EXPECT_THAT(messages_.str(),
              AllOf(HasSubstr("instance 1"),
                    HasSubstr("freegs_pipeline model"),
                    HasSubstr("docs/clip.md")));
  // An instance that has words is one that the model knows.
  workspace_.instances[0].words = {"red apple"};
  ASSERT_TRUE(semantics::WriteInstances(workspace_ / "bootstrap/instances.json",
                                        workspace_.instances)
                  .ok());
  ASSERT_EQ(Query(question), 0) << message_;
  EXPECT_EQ(messages_.str(), "");
}

TEST_F(QueryCommandTest, WhatIsNotThereIsAnAnswer) {
  AddFeatures();
  const nlohmann::json answer = QueryJson(
      {"--text", "red apple", "--min-relevancy", "1", "--out", out()});
  EXPECT_EQ(answer["found"], false);
  EXPECT_TRUE(answer["hits"].empty());
  EXPECT_EQ(answer["best_score"], answer["others"][0]["score"]);
  for (const auto& mask : answer["masks"]) EXPECT_EQ(mask["pixels"], 0);
  ASSERT_EQ(Query({"--text", "red apple", "--query.min_relevancy", "1"}), 0);
  EXPECT_THAT(output_.str(), HasSubstr("not found"));
  // As config.ini says.
  WriteText(workspace_ / "config.ini", "[query]\nmin_relevancy = 1\n");
  EXPECT_EQ(QueryJson({"--text", "red apple"})["found"], false);
}

TEST_F(QueryCommandTest, LargePlanesAnswerWhenAskedFor) {
  AddFeatures();
  workspace_.instances[0].background = true;
  ASSERT_TRUE(
      semantics::WriteInstances(workspace_ / "bootstrap" / "instances.json",
                                workspace_.instances)
          .ok());
  const std::vector<std::string> text = {
      "--text", "red apple", "--min-relevancy", "0"};
  const nlohmann::json without = QueryJson(text);
  EXPECT_EQ(without["hits"][0]["id"], 2);
  EXPECT_EQ(without["plane"]["id"], 1);
  ASSERT_EQ(Query(text), 0);
  EXPECT_THAT(output_.str(), HasSubstr("--background"));
  const nlohmann::json with = QueryJson(
      {"--text", "red apple", "--min-relevancy", "0", "--background"});
  EXPECT_EQ(with["hits"][0]["id"], 1);
  EXPECT_TRUE(with["plane"].is_null());
}

TEST_F(QueryCommandTest, ClicksAnswerWithoutSemantics) {
  const View& view = workspace_.views[2];
  const Image<int32_t> labels = Labels(view);
  for (int32_t label = 0; label < 3; ++label) {
    const auto [x, y] = PixelOf(labels, label);
    const nlohmann::json answer = QueryJson(
        {"--click", "photo2", std::to_string(x), std::to_string(y) + ".7"});
    ASSERT_EQ(answer["hits"].size(), 1u);
    EXPECT_EQ(answer["hits"][0]["id"], label + 1);
    EXPECT_TRUE(answer["hits"][0].contains("point"));
    EXPECT_EQ(answer["query"]["view"], view.name);
  }
  const auto [x, y] = PixelOf(labels, -1);
  ASSERT_EQ(Query({"--click", view.name, std::to_string(x), std::to_string(y)}),
            0);
  EXPECT_THAT(output_.str(), HasSubstr("not found"));
}

TEST_F(QueryCommandTest, ClicksReachPartsAndWholes) {
  const auto [x, y] = PixelOf(Labels(workspace_.views[2]), 1);
  const auto click = [x = x, y = y](std::vector<std::string> more) {
    std::vector<std::string> all = {
        "--click", "photo2", std::to_string(x), std::to_string(y)};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  EXPECT_EQ(Query(click({"--wider", "1"})), 3);
  EXPECT_THAT(message_, HasSubstr("hierarchy.json: no such file"));
  workspace_.AddHierarchy();
  const auto count = [](const nlohmann::json& answer) {
    return answer["hits"][0]["num_gaussians"].get<int>();
  };
  const nlohmann::json thing = QueryJson(click({}));
  EXPECT_EQ(count(thing), 30);
  const nlohmann::json part = QueryJson(click({"--narrower", "1"}));
  EXPECT_EQ(count(part), 15);
  EXPECT_EQ(part["hits"][0]["id"], 4);
  EXPECT_EQ(part["query"]["level"], -1);
  EXPECT_EQ(part["query"]["instance"], 2);
  EXPECT_EQ(Query(click({"--narrower", "1"})), 0);
  EXPECT_THAT(output_.str(),
              HasSubstr("\n4 is not one of the scene's instances"));
  EXPECT_EQ(Query(click({})), 0);
  EXPECT_THAT(output_.str(), Not(HasSubstr("is not one of")));
  const nlohmann::json pair = QueryJson(click({"--wider", "1"}));
  EXPECT_EQ(count(pair), 60);
  EXPECT_NEAR(pair["hits"][0]["instance_score"], 0.8, 1e-6);
  EXPECT_EQ(count(QueryJson(click({"--wider", "5"}))), 90);

  const TemporaryFolder masks;
  const nlohmann::json shown =
      QueryJson(click({"--wider", "2", "--out", (masks / "answer").string()}));
  int64_t pixels = 0;
  for (const nlohmann::json& view : shown["masks"]) {
    pixels += view["pixels"].get<int64_t>();
  }
  EXPECT_GT(pixels, 0);
  EXPECT_EQ(Query(click({"--wider", "1", "--narrower", "1"})), 2);
  EXPECT_THAT(message_, HasSubstr("exclude one another"));
  EXPECT_EQ(Query(click({"--wider", "2", "--wider", "1"})), 2);
  EXPECT_THAT(message_, HasSubstr("--wider is given twice"));
  EXPECT_EQ(Query(click({"--wider", "0"})), 2);
  EXPECT_EQ(Query({"--box", "photo1", "0", "0", "9", "9", "--wider", "1"}), 2);
}

// The hierarchy knows one Gaussian of the clicked thing, which the pixel does
// not show: there is a whole, but no part.
TEST_F(QueryCommandTest, ClicksBesideAllPartsReachTheWhole) {
  const auto [x, y] = PixelOf(Labels(workspace_.views[2]), 1);
  workspace_.AddHierarchy();
  const auto file = workspace_.path() / "bootstrap" / "hierarchy.json";
  const auto hierarchy =
      semantics::ReadHierarchy(file, workspace_.model.size());
  ASSERT_TRUE(hierarchy.ok());
  const auto answer_with_only = [&, x = x, y = y](size_t known,
                                                  const char* option) {
    semantics::Hierarchy poorer = *hierarchy;
    for (size_t g = 1; g < poorer.part_of_gaussian.size(); g += 4) {
      if (g != known) poorer.part_of_gaussian[g] = -1;
    }
    EXPECT_TRUE(semantics::WriteHierarchy(file, poorer).ok());
    return Query({"--click",
                  "photo2",
                  std::to_string(x),
                  std::to_string(y),
                  option,
                  "1"});
  };
  bool found = false;
  for (size_t g = 1; !found && g < workspace_.model.size(); g += 4) {
    found = answer_with_only(g, "--narrower") == 2;
    if (!found) continue;
    EXPECT_THAT(message_, HasSubstr("click another pixel"));
    EXPECT_EQ(answer_with_only(g, "--wider"), 0) << message_;
    const nlohmann::json wider = QueryJson({"--click",
                                            "photo2",
                                            std::to_string(x),
                                            std::to_string(y),
                                            "--wider",
                                            "1"});
    EXPECT_NE(wider.at("hits").at(0).at("id"),
              wider.at("query").at("instance"));
  }
  EXPECT_TRUE(found);
  EXPECT_EQ(answer_with_only(0, "--wider"), 2);
}

TEST_F(QueryCommandTest, BoxesAnswerWithoutSemantics) {
  const Image<int32_t> labels = Labels(workspace_.views[1]);
  int x0 = 64, x1 = 0, y0 = 48, y1 = 0;
  for (int y = 0; y < labels.height(); ++y) {
    for (int x = 0; x < labels.width(); ++x) {
      if (labels(x, y) != 1) continue;
      x0 = std::min(x0, x);
      x1 = std::max(x1, x + 1);
      y0 = std::min(y0, y);
      y1 = std::max(y1, y + 1);
    }
  }
  const nlohmann::json answer = QueryJson({"--box",
                                           "photo1.png",
                                           std::to_string(x0),
                                           std::to_string(y0),
                                           std::to_string(x1),
                                           std::to_string(y1)});
  ASSERT_FALSE(answer["hits"].empty());
  EXPECT_GT(answer["hits"][0]["score"].get<double>(), 0.7);
  EXPECT_EQ(Query({"--box", "photo1", "-9", "-9", "-1", "-1"}), 2);
  EXPECT_THAT(message_, HasSubstr("no area"));
}

TEST_F(QueryCommandTest, ExamplesGoByTheImageNetwork) {
  const auto encoder = semantics::OpenCvClip::Open(TinyClip());
  ASSERT_TRUE(encoder.ok());
  const std::string image = (TinyClip() / "reference.png").string();
  const auto picture = ReadRgb(image);
  const auto vector = (*encoder)->EncodeImage(*picture);
  ASSERT_TRUE(vector.ok());
  semantics::InstanceFeatures features;
  features.dim = (*encoder)->embedding_dim();
  features.model = "a model that has moved";
  features.model_hash = (*encoder)->model_hash();
  features.features.resize(features.dim);
  for (const float value : *vector) features.features.push_back(-value);
  features.features.insert(
      features.features.end(), vector->begin(), vector->end());
  Write(features);
  const nlohmann::json answer =
      QueryJson({"--example", image, "--model", TinyClip().string()});
  ASSERT_EQ(answer["hits"].size(), 1u);
  EXPECT_EQ(answer["hits"][0]["id"], 3);
  EXPECT_NEAR(answer["hits"][0]["score"].get<double>(), 1, 1e-4);
  EXPECT_EQ(answer["others"].size(), 1u);
  EXPECT_EQ(Query({"--example", "none.png", "--model", TinyClip().string()}),
            3);
  EXPECT_THAT(message_, HasSubstr("none.png"));
}

TEST_F(QueryCommandTest, WrongUsageIs2) {
  AddFeatures();
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{},
        {"--text", "a", "--click", "photo1", "1", "1"},
        {"--text", " "},
        {"--text", "\xff\xfe"},
        {"--text"},
        {"--click", "photo1", "1"},
        {"--click", "photo1", "1", "y"},
        {"--click", "photo1", "1", "nan"},
        {"--click", "photo1", "1", "1", "--click", "photo1", "1", "1"},
        {"--click", "photo1", "64", "1"},
        {"--click", "photo1", "-1", "1"},
        {"--click", "photo1", "1e300", "1"},
        {"--box", "photo1", "1", "1", "2"},
        {"--text", "a", "--min-relevancy", "2"},
        {"--text", "a", "--max-hits", "-1"},
        {"--text", "a", "--no-align"},
        {"--text", "a", "--min-cosine", "0.3"},
        {"--click", "photo1", "1", "1", "--min-relevancy", "0.3"},
        {"--click", "photo1", "1", "1", "--model", "nope"},
        {"--text", "a", "second workspace"}}) {
    EXPECT_EQ(Query(arguments), 2) << testing::PrintToString(arguments);
  }
  EXPECT_EQ(Query({"--click", "photo9", "1", "1"}), 2);
  EXPECT_THAT(message_, AllOf(HasSubstr("photo9"), HasSubstr("photo5.png")));
}

TEST_F(QueryCommandTest, WithoutSemanticsTextSaysWhatToDo) {
  EXPECT_EQ(Query({"--text", "red apple"}), 3);
  EXPECT_THAT(message_,
              AllOf(HasSubstr("instance_features.json"),
                    HasSubstr("--click"),
                    HasSubstr("--bootstrap.mode lift"),
                    HasSubstr(kMissing)));
}

TEST_F(QueryCommandTest, AnswersNothingOfAnotherReconstruction) {
  AddFeatures();
  pipeline::StageRecord record;
  record.fingerprint.stage = "bootstrap";
  record.fingerprint.inputs["reconstruct/point_cloud.ply"] = {
      .hash = "0123456789abcdef0123456789abcdef", .files = 1};
  ASSERT_TRUE(
      pipeline::WriteStageRecord(workspace_ / "bootstrap", record).ok());
  for (const std::vector<std::string>& question :
       {std::vector<std::string>{"--text", "red apple"},
        {"--click", "photo1", "1", "1"}}) {
    EXPECT_EQ(Query(question), 3);
    EXPECT_THAT(
        message_,
        AllOf(HasSubstr("another reconstruction"), HasSubstr(kMissing)));
  }
}

TEST_F(QueryCommandTest, WithoutBootstrapEveryQuestionNamesTheStage) {
  std::filesystem::remove_all(workspace_ / "bootstrap");
  EXPECT_EQ(Query({"--text", "red apple"}), 3);
  EXPECT_THAT(message_, HasSubstr(kMissing));
  EXPECT_EQ(Query({"--click", "photo1", "1", "1"}), 3);
  EXPECT_THAT(message_, HasSubstr(kMissing));
  std::filesystem::remove_all(workspace_.path());
  EXPECT_EQ(Query({"--text", "red apple"}), 3);
  EXPECT_THAT(message_, HasSubstr("no such workspace"));
}

TEST_F(QueryCommandTest, AnotherOrMissingModelIs5) {
  AddFeatures();
  EXPECT_EQ(Query({"--text", "a", "--model", (out_ / "none").string()}), 5);
  EXPECT_THAT(message_, HasSubstr("none"));
  const ModelCopy other;
  nlohmann::json info = other.Info();
  info["mean"][0] = 0.25;
  other.SetInfo(info);
  EXPECT_EQ(Query({"--text", "a", "--model", other.path().string()}), 5);
  EXPECT_THAT(message_,
              AllOf(HasSubstr("another model"),
                    HasSubstr(other.path().string()),
                    HasSubstr("--model")));
}

TEST_F(QueryCommandTest, FilesThatDisagreeAreBadInput) {
  AddFeatures();
  auto features = *semantics::ReadInstanceFeatures(FeatureFile());
  features.features.resize(2 * static_cast<size_t>(features.dim));
  Write(features);
  EXPECT_EQ(Query({"--text", "a"}), 3);
  EXPECT_THAT(message_, AllOf(HasSubstr("instance 3"), HasSubstr(kMissing)));
  WriteText(FeatureFile(), "{\"dim\": 3}");
  EXPECT_EQ(Query({"--text", "a"}), 3);
  EXPECT_THAT(message_, HasSubstr("instance_features.json"));
  // A label that instances.json does not have, and one that no scene of so few
  // Gaussians can have.
  const auto [x, y] = PixelOf(Labels(workspace_.views[1]), 0);
  const std::vector<std::string> click = {
      "--click", "photo1", std::to_string(x), std::to_string(y)};
  const int last = static_cast<int>(workspace_.labels.size());
  for (const auto& [id, message] :
       {std::pair(last, "instances.json has not"),
        std::pair(last + 1, "instances.json: has an instance"),
        std::pair(0x7fffffff, "instances.json: has an instance 2147483647")}) {
    workspace_.instances[0].id = id;
    ASSERT_TRUE(
        semantics::WriteInstances(workspace_ / "bootstrap" / "instances.json",
                                  workspace_.instances)
            .ok());
    EXPECT_EQ(Query(click), 3);
    EXPECT_THAT(message_, HasSubstr(message));
  }
}

TEST_F(QueryCommandTest, StopsWhenAsked) {
  cancellation_.Cancel();
  EXPECT_EQ(Query({"--click", "photo1", "1", "1"}), 130);
}

}  // namespace
}  // namespace freegs::stages
