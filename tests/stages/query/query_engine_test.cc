// SPDX-License-Identifier: BSD-3-Clause

#include "stages/query/query_engine.h"

#include <algorithm>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "stages/query/query_answer.h"
#include "tests/stages/synthetic_workspace.h"

namespace freegs::stages {
namespace {

class QueryEngineTest : public testing::Test {
 protected:
  QueryEngineTest() {
    workspace_.AddInstances();
    request_.workspace = workspace_.path();
  }

  QueryAnswer Answer() {
    QueryScene scene;
    const Status loaded = LoadQueryScene(request_, messages_, &scene);
    EXPECT_TRUE(loaded.ok()) << loaded.message();
    for (const int id : planes_) {
      scene.instances[static_cast<size_t>(id) - 1].background = true;
      scene.is_background[static_cast<size_t>(id) - 1] = 1;
    }
    const auto answer = FindAnswer(request_, pool_, &scene, &networks_);
    EXPECT_TRUE(answer.ok()) << answer.status().message();
    return answer.ok() ? *answer : QueryAnswer();
  }

  Image<int32_t> Labels(const View& view) {
    return splat::RenderLabels(workspace_.model,
                               view.camera,
                               view.cam_from_world,
                               {},
                               pool_,
                               workspace_.labels);
  }

  // The corners of the box around the pixels of the label.
  static std::vector<double> BoxAround(const Image<int32_t>& labels,
                                       int32_t label) {
    int x0 = labels.width(), x1 = 0, y0 = labels.height(), y1 = 0;
    for (int y = 0; y < labels.height(); ++y) {
      for (int x = 0; x < labels.width(); ++x) {
        if (labels(x, y) != label) continue;
        x0 = std::min(x0, x);
        x1 = std::max(x1, x + 1);
        y0 = std::min(y0, y);
        y1 = std::max(y1, y + 1);
      }
    }
    return {1.0 * x0, 1.0 * y0, 1.0 * x1, 1.0 * y1};
  }

  static std::vector<std::pair<int, double>> Listed(
      const std::vector<ScoredInstance>& instances) {
    std::vector<std::pair<int, double>> listed;
    for (const ScoredInstance& instance : instances) {
      listed.emplace_back(instance.id, instance.score);
    }
    return listed;
  }

  SyntheticWorkspace workspace_;
  std::vector<int> planes_;  // Ids of those that are large planes.
  QueryRequest request_;
  QueryNetworks networks_;
  std::ostringstream messages_;
  ThreadPool pool_{2};
};

TEST_F(QueryEngineTest, ABoxNamesThePlaneThatFitsItBetter) {
  request_.box = ViewPlace{"photo1", BoxAround(Labels(workspace_.views[1]), 1)};
  const QueryAnswer thing = Answer();
  ASSERT_EQ(thing.hits.size(), 1u);
  EXPECT_EQ(thing.hits[0].id, 2);
  EXPECT_FALSE(thing.plane.has_value());
  ASSERT_FALSE(thing.others.empty());

  planes_ = {2};
  const QueryAnswer best_of_others = Answer();
  ASSERT_TRUE(best_of_others.plane.has_value());
  EXPECT_EQ(best_of_others.plane->id, 2);
  EXPECT_EQ(best_of_others.plane->score, thing.hits[0].score);
  ASSERT_EQ(best_of_others.hits.size(), 1u);
  EXPECT_EQ(best_of_others.hits[0].id, thing.others[0].id);
  const nlohmann::json json = ToJson(best_of_others, workspace_.instances);
  EXPECT_EQ(json["plane"]["id"], 2);
  EXPECT_EQ(json["best_score"], thing.others[0].score);
  EXPECT_LT(json["best_score"], json["plane"]["score"]);

  // A plane that fits less than the answer is not worth a word.
  planes_ = {thing.others[0].id};
  EXPECT_FALSE(Answer().plane.has_value());
}

TEST_F(QueryEngineTest, ABoxWithNothingButPlanesFindsNothing) {
  request_.box = ViewPlace{"photo1", BoxAround(Labels(workspace_.views[1]), 1)};
  planes_ = {1, 2, 3};
  const QueryAnswer without = Answer();
  ASSERT_TRUE(without.plane.has_value());
  const nlohmann::json json = ToJson(without, workspace_.instances);
  EXPECT_EQ(json["found"], false);
  EXPECT_EQ(json["plane"]["id"], 2);
  EXPECT_TRUE(json["best_score"].is_null());

  request_.text_options.background = true;
  const QueryAnswer with = Answer();
  ASSERT_EQ(with.hits.size(), 1u);
  EXPECT_EQ(with.hits[0].id, 2);
  EXPECT_FALSE(with.plane.has_value());
}

// A pixel where all three instances have some weight.
TEST_F(QueryEngineTest, ALevelLeavesTheOtherInstancesWhole) {
  workspace_.AddHierarchy();
  request_.max_hits = 0;
  QueryAnswer plain;
  for (double x = 0.5; plain.hits.size() < 3 && x < 64; ++x) {
    request_.click = ViewPlace{"photo2", {x, 24.5}};
    plain = Answer();
  }
  ASSERT_EQ(plain.hits.size(), 3u);
  const int clicked = plain.hits[0].id;
  std::vector<std::pair<int, double>> others = Listed(plain.hits);
  others.erase(others.begin());
  for (const int level : {-1, 1, 2}) {
    request_.level = level;
    const QueryAnswer answer = Answer();
    EXPECT_EQ(answer.question["instance"], clicked);
    ASSERT_EQ(answer.hits.size(), 1u) << level;
    EXPECT_EQ(answer.hits[0].id, 4);
    EXPECT_EQ(Listed(answer.others), others) << level;
    EXPECT_EQ(answer.hits[0].score > plain.hits[0].score, level > 0) << level;
  }
}

}  // namespace
}  // namespace freegs::stages
