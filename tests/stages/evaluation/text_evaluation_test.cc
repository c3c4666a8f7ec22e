// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation/text_evaluation.h"

#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "stages/evaluation/consistency_evaluation.h"
#include "stages/evaluation/evaluation_report.h"
#include "tests/stages/ball_scene.h"

namespace freegs::stages {
namespace {

class TextEvaluationTest : public BallScene {
 protected:
  StatusOr<std::optional<TextQuality>> Measure(
      const std::map<std::string, TextAnswer>& answers) {
    return MeasureTextQuality(Context(MakeScene()), labels_, answers);
  }
};

TEST_F(TextEvaluationTest, RightAnswersArePerfect) {
  const auto text = Measure(
      {{"ball 1", {0, 0.9}}, {"ball 2", {1, 0.8}}, {"ball 3", {2, 0.7}}});
  ASSERT_TRUE(text.ok() && text->has_value());
  EXPECT_GT(*(*text)->miou, 0.97);
  EXPECT_GT(*(*text)->mbiou, 0.9);
  EXPECT_GT((*text)->boxes->miou, 0.9);
  EXPECT_EQ((*text)->boxes->recall50, 1);
  ASSERT_EQ((*text)->labels.size(), 3u);
  EXPECT_EQ((*text)->labels[1].label, "ball 2");
  EXPECT_EQ((*text)->labels[1].num_objects, 1);
  EXPECT_EQ((*text)->labels[1].num_views, 3);
  EXPECT_EQ((*text)->labels[1].answer.relevancy, 0.8);
}

TEST_F(TextEvaluationTest, WrongAndMissingAnswersAreNothing) {
  const auto text = Measure({{"ball 1", {0, 0.9}}, {"ball 2", {2, 0.8}}});
  ASSERT_TRUE(text.ok() && text->has_value());
  const auto& labels = (*text)->labels;
  EXPECT_GT(*labels[0].iou, 0.97);
  EXPECT_LT(*labels[1].iou, 0.01);
  EXPECT_EQ(*labels[1].box_iou, 0);
  // Nobody's pixels are not the mask of no answer.
  EXPECT_EQ(*labels[2].iou, 0);
  EXPECT_EQ(*labels[2].boundary_iou, 0);
  EXPECT_EQ(*labels[2].box_iou, 0);
  EXPECT_NEAR(*(*text)->miou, (*labels[0].iou + *labels[1].iou) / 3, 1e-12);
  EXPECT_NEAR((*text)->boxes->recall25, 1.0 / 3, 1e-12);
}

TEST_F(TextEvaluationTest, ObjectsOfOneLabelAreOne) {
  for (TrueObject& object : truth_.objects) object.label = "ball";
  const auto text = Measure({{"ball", {1, 0.9}}});
  ASSERT_TRUE(text.ok() && text->has_value());
  ASSERT_EQ((*text)->labels.size(), 1u);
  const LabelResult& label = (*text)->labels[0];
  EXPECT_EQ(label.num_objects, 3);
  // One of three balls is less than the union of their masks ...
  EXPECT_LT(*label.iou, 0.6);
  EXPECT_GT(*label.iou, 0.1);
  // ... but as a box it is one of them.
  EXPECT_GT(*label.box_iou, 0.9);
}

TEST_F(TextEvaluationTest, WithoutLabelsThereIsNothing) {
  for (TrueObject& object : truth_.objects) object.label.clear();
  const auto text = Measure({});
  ASSERT_TRUE(text.ok());
  EXPECT_FALSE(text->has_value());
}

TEST_F(TextEvaluationTest, BoxesAloneAreJudgedToo) {
  truth_.masks.clear();
  const auto text = Measure({{"ball 1", {0, 0.9}}});
  ASSERT_TRUE(text.ok() && text->has_value());
  EXPECT_FALSE((*text)->miou.has_value());
  EXPECT_NEAR((*text)->boxes->recall50, 1.0 / 3, 1e-12);
}

TEST_F(TextEvaluationTest, AnswersOutOfRangeAreHarmless) {
  const auto text = Measure({{"ball 1", {1000000, 0.9}}});
  ASSERT_TRUE(text.ok() && text->has_value());
  EXPECT_EQ(*(*text)->labels[0].iou, 0);
  EXPECT_EQ(*(*text)->labels[0].box_iou, 0);
}

TEST_F(TextEvaluationTest, ReportHasATableOfLabels) {
  EvaluationReport report;
  report.text = *Measure({{"ball 1", {0, 0.9}}});
  report.instances = *MeasureInstanceQuality(Context(MakeScene()), labels_);
  report.text_model = "models/x";
  const nlohmann::json json = ToJson(report);
  EXPECT_GT(json["text_miou"], 0.3);
  EXPECT_GT(json["text_mbiou"], 0.3);
  EXPECT_NEAR(json["text_box_recall50"], 1.0 / 3, 1e-12);
  EXPECT_EQ(json["text_from"], "instances");
  EXPECT_EQ(json["text_model"], "models/x");
  EXPECT_TRUE(json["text_threshold"].is_null());
  ASSERT_EQ(json["labels"].size(), 3u);
  EXPECT_EQ(json["labels"][0]["label"], "ball 1");
  EXPECT_EQ(json["labels"][0]["instance"], 1);
  EXPECT_TRUE(json["labels"][1]["instance"].is_null());
  EXPECT_GT(json["objects"][0]["text_iou"], 0.9);
  EXPECT_EQ(json["objects"][1]["text_iou"], 0);
  std::ostringstream table;
  PrintTable(report, table);
  EXPECT_NE(table.str().find("text mIoU"), std::string::npos);
  EXPECT_NE(table.str().find("relevancy"), std::string::npos);
  EXPECT_NE(table.str().find("best instance"), std::string::npos);
  report.text_from_gaussians = true;
  EXPECT_EQ(ToJson(report)["text_from"], "gaussians");
  std::ostringstream of_gaussians;
  PrintTable(report, of_gaussians);
  EXPECT_NE(of_gaussians.str().find("all Gaussians relevant to each label"),
            std::string::npos);
  EXPECT_EQ(of_gaussians.str().find("label's best instance"),
            std::string::npos);
}

using ConsistencyTest = BallScene;

TEST_F(ConsistencyTest, WholeBallsAreConsistent) {
  const auto consistency =
      MeasureViewConsistency(MakeScene(), labels_, cancellation_, pool_);
  ASSERT_TRUE(consistency.ok()) << consistency.status().message();
  ASSERT_TRUE(consistency->has_value());
  EXPECT_GE((*consistency)->num_pairs, 5);
  EXPECT_EQ((*consistency)->instances.size(), 3u);
  EXPECT_GT((*consistency)->mean, 0.9);
}

TEST_F(ConsistencyTest, IntermingledInstancesAreLess) {
  std::vector<int32_t> mixed = labels_;
  for (size_t i = 0; i < mixed.size(); ++i) {
    mixed[i] = static_cast<int32_t>(RandomIndex(5, i, 0, 3));
  }
  const auto whole =
      MeasureViewConsistency(MakeScene(), labels_, cancellation_, pool_);
  const auto parts =
      MeasureViewConsistency(MakeScene(), mixed, cancellation_, pool_);
  ASSERT_TRUE(whole.ok() && parts.ok() && parts->has_value());
  EXPECT_LT((*parts)->mean, (*whole)->mean - 0.05);
}

TEST_F(ConsistencyTest, NothingWithoutInstancesOrNeighbours) {
  WorkspaceScene scene = MakeScene();
  const std::vector<int32_t> none(labels_.size(), -1);
  EXPECT_FALSE(
      MeasureViewConsistency(scene, none, cancellation_, pool_)->has_value());
  EXPECT_FALSE(MeasureViewConsistency(scene, {}, cancellation_, pool_).ok());
  scene.train.resize(1);
  EXPECT_FALSE(MeasureViewConsistency(scene, labels_, cancellation_, pool_)
                   ->has_value());
  scene.train.clear();
  EXPECT_FALSE(MeasureViewConsistency(scene, labels_, cancellation_, pool_)
                   ->has_value());
}

TEST_F(ConsistencyTest, StopsWhenCancelled) {
  const WorkspaceScene scene = MakeScene();
  cancellation_.Cancel();
  EXPECT_EQ(MeasureViewConsistency(scene, labels_, cancellation_, pool_)
                .status()
                .code(),
            StatusCode::kInterrupted);
}

}  // namespace
}  // namespace freegs::stages
