// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation/evaluation.h"

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "stages/evaluation/evaluation_report.h"
#include "stages/evaluation/instance_evaluation.h"
#include "stages/evaluation/text_evaluation.h"
#include "stages/evaluation/true_masks.h"
#include "stages/scene/scene_alignment.h"
#include "tests/stages/ball_scene.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

using EvaluationTest = BallScene;

TEST_F(EvaluationTest, APerfectSceneIsPerfect) {
  const WorkspaceScene scene = MakeScene();
  const auto poses = AlignWithViews(scene, truth_.cameras.train, "truth");
  ASSERT_TRUE(poses.ok()) << poses.status().message();
  EXPECT_EQ(poses->residuals.size(), 10u);
  EXPECT_LT(poses->max_rotation_deg, 1e-5);
  EXPECT_LT(poses->max_centre, 1e-9);
  const Sim3d found = poses->target_from_source;
  EXPECT_NEAR(found.scale, 0.4, 1e-9);
  EvaluationContext context = Context(scene);
  context.truth_from_scene = found;

  const auto test = MeasureTestQuality(context);
  ASSERT_TRUE(test.ok() && test->has_value());
  EXPECT_EQ((*test)->views.size(), 3u);
  EXPECT_GT((*test)->psnr, 45);
  EXPECT_GT((*test)->ssim, 0.995);

  const auto instances = MeasureInstanceQuality(context, labels_);
  ASSERT_TRUE(instances.ok() && instances->has_value());
  const InstanceQuality& quality = **instances;
  EXPECT_GT(*quality.instance_miou, 0.97);
  EXPECT_GT(*quality.click_miou, 0.97);
  EXPECT_GT(quality.boxes->miou, 0.9);
  EXPECT_EQ(quality.boxes->recall50, 1);
  ASSERT_EQ(quality.objects.size(), 3u);
  EXPECT_EQ(quality.objects[1].label, "ball 2");
  EXPECT_EQ(quality.objects[1].instance, 1);
  EXPECT_EQ(quality.objects[1].num_views, 3);
  ASSERT_TRUE(quality.balance);
  EXPECT_EQ(*quality.balance->instances_per_object, 1);
  EXPECT_EQ(*quality.balance->objects_per_instance, 1);
  EXPECT_EQ(quality.panoptic.size(), 3u);
  EXPECT_EQ(quality.panoptic_sum.true_positives, 9);
  EXPECT_EQ(quality.panoptic_sum.false_positives, 0);
  EXPECT_GT(*quality.panoptic_sum.Quality(), 0.97);
}

TEST_F(EvaluationTest, MergedObjectsCost) {
  const WorkspaceScene scene = MakeScene();
  std::vector<int32_t> merged = labels_;
  for (int32_t& label : merged) label = label == 2 ? 1 : label;
  const auto instances = MeasureInstanceQuality(Context(scene), merged);
  ASSERT_TRUE(instances.ok() && instances->has_value());
  const InstanceQuality& quality = **instances;
  EXPECT_GT(*quality.objects[0].instance_iou, 0.95);
  EXPECT_LT(*quality.objects[1].instance_iou, 0.9);
  EXPECT_LT(*quality.objects[2].click_iou, 0.9);
  EXPECT_NEAR(*quality.objects[2].box_iou, 0.4, 0.1);
  EXPECT_EQ(quality.boxes->recall25, 1);
  EXPECT_NEAR(quality.boxes->recall50, 1.0 / 3, 1e-9);
}

TEST_F(EvaluationTest, WithoutInstancesEverythingIsMissed) {
  const WorkspaceScene scene = MakeScene();
  const std::vector<int32_t> none(labels_.size(), -1);
  const auto instances = MeasureInstanceQuality(Context(scene), none);
  ASSERT_TRUE(instances.ok() && instances->has_value());
  EXPECT_EQ(*(*instances)->instance_miou, 0);
  EXPECT_EQ(*(*instances)->click_miou, 0);
  EXPECT_EQ((*instances)->boxes->miou, 0);
  EXPECT_EQ((*instances)->objects[0].instance, -1);
  EXPECT_EQ(*(*instances)->panoptic_sum.Quality(), 0);
}

TEST_F(EvaluationTest, WithoutMasksBoxesFindTheirInstances) {
  const WorkspaceScene scene = MakeScene();
  truth_.masks.clear();
  truth_.objects.back().aabb = semantics::AxisAlignedBox{
      Eigen::Vector3d::Constant(50), Eigen::Vector3d::Constant(51)};
  const auto instances = MeasureInstanceQuality(Context(scene), labels_);
  ASSERT_TRUE(instances.ok() && instances->has_value());
  const InstanceQuality& quality = **instances;
  EXPECT_FALSE(quality.instance_miou.has_value());
  EXPECT_TRUE(quality.panoptic.empty());
  EXPECT_EQ(quality.objects[1].instance, 1);
  EXPECT_GT(*quality.objects[1].box_iou, 0.9);
  EXPECT_EQ(quality.objects[2].instance, -1);
  EXPECT_EQ(*quality.objects[2].box_iou, 0);
  EXPECT_NEAR(quality.boxes->recall50, 2.0 / 3, 1e-9);
}

// Gaussians of a scene are long and flat.
TEST_F(EvaluationTest, BoxesInTheFrameOfTheTruthAreThoseOfTheTruth) {
  for (size_t i = 0; i < true_model_.size(); ++i) {
    true_model_.log_scales[3 * i] += 1;
    true_model_.log_scales[3 * i + 2] -= 2;
  }
  const WorkspaceScene scene = MakeScene();
  const std::vector<semantics::Instance> found =
      InstancesInTruth(Context(scene), labels_);
  const std::vector<semantics::Instance> expected =
      semantics::BuildInstances(true_model_,
                                labels_,
                                3,
                                {},
                                {},
                                std::nullopt,
                                semantics::InstanceBoxOptions(),
                                pool_);
  ASSERT_EQ(found.size(), 3u);
  for (size_t k = 0; k < 3; ++k) {
    EXPECT_LT((found[k].aabb.min - expected[k].aabb.min).norm(), 1e-4);
    EXPECT_LT((found[k].aabb.max - expected[k].aabb.max).norm(), 1e-4);
  }
}

// The mean is over pairs of an object and a view, and each click counts what it
// finds: ball 1 has a band about its middle that is an instance of its own.
TEST_F(EvaluationTest, MeansAreOverObjectsAndViews) {
  const WorkspaceScene scene = MakeScene();
  std::vector<int32_t> labels = labels_;
  for (size_t i = 0; i < labels.size(); ++i) {
    const float height = true_model_.means[3 * i + 2];
    if (labels[i] == 0 && height > -0.1f && height < 0.25f) labels[i] = 3;
    if (labels[i] == 2) labels[i] = 1;  // Balls 2 and 3 are one instance.
  }
  // Of ball 3 one view shows nothing, and one too little to be judged.
  const auto hide = [&](const std::string& view, int left) {
    const fs::path& path = truth_.masks[view][0].path;
    ImageU16 ids = *ReadLabels(path);
    for (size_t i = 0; i < ids.size(); ++i) {
      if (ids.data()[i] == 3 && left-- <= 0) ids.data()[i] = 0;
    }
    ASSERT_TRUE(WriteLabels(path, ids).ok());
  };
  hide(truth_.cameras.test[0].name, 0);
  hide(truth_.cameras.test[1].name, 29);
  const auto instances = MeasureInstanceQuality(Context(scene), labels);
  ASSERT_TRUE(instances.ok() && instances->has_value());
  const std::vector<ObjectResult>& objects = (*instances)->objects;
  ASSERT_EQ(objects.size(), 3u);
  EXPECT_EQ(objects[2].num_views, 1);
  double sum = 0;
  int pairs = 0;
  for (const ObjectResult& object : objects) {
    sum += object.num_views * *object.instance_iou;
    pairs += object.num_views;
  }
  EXPECT_EQ(pairs, 7);
  EXPECT_NEAR(*(*instances)->instance_miou, sum / pairs, 1e-12);
  EXPECT_LT(*objects[0].click_iou, *objects[0].instance_iou - 0.05);

  // That of labels is over the views of each label, and then over the labels.
  const auto text = MeasureTextQuality(
      Context(scene), labels_, {{"ball 1", {0, 0.9}}, {"ball 2", {1, 0.9}}});
  ASSERT_TRUE(text.ok() && text->has_value());
  const std::vector<LabelResult>& names = (*text)->labels;
  ASSERT_EQ(names.size(), 3u);
  EXPECT_EQ(names[2].num_views, 1);
  EXPECT_NEAR(*(*text)->miou,
              (*names[0].iou + *names[1].iou + *names[2].iou) / 3,
              1e-12);
}

// Photos kept from training are shown in the exposure of their neighbours.
TEST_F(EvaluationTest, HoldoutPhotosHaveTheirNeighboursExposure) {
  WorkspaceScene scene = MakeScene();
  scene.holdout = {scene.train.back()};
  scene.train.pop_back();
  View& view = scene.holdout[0];
  ImageU8 dark =
      ToU8(splat::RenderView(
               scene.model, view.camera, view.cam_from_world, {}, pool_)
               .color);
  for (size_t i = 0; i < dark.size(); ++i) dark.data()[i] /= 2;
  view.name = "frame_9.png";  // Without loss.
  ASSERT_TRUE(WriteImage(folder_ / view.name, dark).ok());
  splat::AffineColor half;
  for (float& value : half.values) value *= 0.5f;
  scene.exposures = {{"frame_8.jpg", half}};
  const auto quality =
      MeasureHoldoutQuality(scene, folder_, {}, cancellation_, pool_);
  ASSERT_TRUE(quality.ok() && quality->has_value());
  EXPECT_GT((*quality)->psnr, 45);
  scene.exposures.clear();
  const auto without =
      MeasureHoldoutQuality(scene, folder_, {}, cancellation_, pool_);
  ASSERT_TRUE(without.ok() && without->has_value());
  EXPECT_LT((*without)->psnr, 25);
}

// Single precision has steps of half a unit there.
TEST_F(EvaluationTest, ATruthInTheCoordinatesOfAMapHasTheSameBoxes) {
  const WorkspaceScene scene = MakeScene();
  const Eigen::Vector3d far(5e6, -4e6, 100);
  truth_.masks.clear();
  const auto near_by = MeasureInstanceQuality(Context(scene), labels_);
  const std::vector<semantics::Instance> instances =
      InstancesInTruth(Context(scene), labels_);
  for (TrueObject& object : truth_.objects) {
    object.aabb->min += far;
    object.aabb->max += far;
  }
  truth_from_scene_.translation += far;
  const auto far_away = MeasureInstanceQuality(Context(scene), labels_);
  ASSERT_TRUE(near_by.ok() && near_by->has_value());
  ASSERT_TRUE(far_away.ok() && far_away->has_value());
  EXPECT_GT((*far_away)->boxes->miou, 0.9);
  EXPECT_NEAR((*far_away)->boxes->miou, (*near_by)->boxes->miou, 1e-4);
  const std::vector<semantics::Instance> moved =
      InstancesInTruth(Context(scene), labels_);
  ASSERT_EQ(moved.size(), instances.size());
  for (size_t k = 0; k < moved.size(); ++k) {
    EXPECT_LT((moved[k].centre - far - instances[k].centre).norm(), 1e-4);
    EXPECT_LT((moved[k].aabb.min - far - instances[k].aabb.min).norm(), 1e-4);
    EXPECT_LT((moved[k].aabb.max - far - instances[k].aabb.max).norm(), 1e-4);
    EXPECT_LT((moved[k].obb.centre - far - instances[k].obb.centre).norm(),
              1e-4);
  }
}

TEST_F(EvaluationTest, AnObjectThatNoTestViewShowsIsFoundByItsBox) {
  const WorkspaceScene scene = MakeScene();
  for (const auto& [name, files] : truth_.masks) {
    StatusOr<ImageU16> mask = ReadLabels(files[0].path);
    ASSERT_TRUE(mask.ok()) << mask.status().message();
    std::replace(
        mask->data(), mask->data() + mask->size(), uint16_t{3}, uint16_t{0});
    ASSERT_TRUE(WriteLabels(files[0].path, *mask).ok());
  }
  const auto instances = MeasureInstanceQuality(Context(scene), labels_);
  ASSERT_TRUE(instances.ok() && instances->has_value());
  const ObjectResult& hidden = (*instances)->objects[2];
  EXPECT_EQ(hidden.num_views, 0);
  EXPECT_EQ(hidden.instance, 2);
  EXPECT_GT(*hidden.box_iou, 0.9);
}

TEST_F(EvaluationTest, MasksMayBeSmallerButNotOfAnotherShape) {
  const View& view = truth_.cameras.test[0];
  const fs::path path = truth_.masks[view.name][0].path;
  ASSERT_TRUE(WriteLabels(path, ImageU16(4, 3, 1)).ok());
  EXPECT_TRUE(ReadTrueMasks(truth_, view, pool_).ok());
  ASSERT_TRUE(WriteLabels(path, ImageU16(2, 2, 1)).ok());
  EXPECT_EQ(ReadTrueMasks(truth_, view, pool_).status().code(),
            StatusCode::kBadInput);
}

TEST_F(EvaluationTest, LargeMasksAreComparedReduced) {
  const WorkspaceScene scene = MakeScene();
  int num_views = 0;
  const auto compare = [&](const JudgedView& view) {
    ++num_views;
    EXPECT_EQ(std::max(view.rendered.width(), view.rendered.height()), 48);
    for (const ImageU16& layer : view.truth) {
      EXPECT_EQ(layer.width(), view.rendered.width());
      const auto overlap = semantics::CountOverlap(layer, view.rendered);
      EXPECT_TRUE(overlap.ok());
      if (!overlap.ok()) return overlap.status();
      for (const auto& [object, pixels] : overlap->truth_pixels) {
        if (pixels < kMinMaskPixels) continue;
        EXPECT_GT(semantics::BestMatch(*overlap, object)->iou, 0.7);
      }
    }
    return Status();
  };
  EXPECT_TRUE(Context(scene).ForEachView(labels_, compare, 48).ok());
  EXPECT_EQ(num_views, 3);
}

TEST_F(EvaluationTest, WithoutTruthThereIsNothing) {
  const WorkspaceScene scene = MakeScene();
  for (const View& view : truth_.cameras.test) {
    fs::remove(truth_.photos[view.name]);
    fs::remove(truth_.masks[view.name][0].path);
  }
  truth_.photos.clear();
  truth_.masks.clear();
  for (TrueObject& object : truth_.objects) object.aabb.reset();
  const auto test = MeasureTestQuality(Context(scene));
  ASSERT_TRUE(test.ok());
  EXPECT_FALSE(test->has_value());
  const auto instances = MeasureInstanceQuality(Context(scene), labels_);
  ASSERT_TRUE(instances.ok());
  EXPECT_FALSE(instances->has_value());
  const auto holdout =
      MeasureHoldoutQuality(scene, folder_, {}, cancellation_, pool_);
  ASSERT_TRUE(holdout.ok());
  EXPECT_FALSE(holdout->has_value());
}

TEST_F(EvaluationTest, MasksThatLeaveNothingOfTheHoldout) {
  WorkspaceScene scene = MakeScene();
  scene.holdout = {scene.train.back()};
  scene.train.pop_back();
  const View& view = scene.holdout[0];
  const int width = view.camera.width;
  const int height = view.camera.height;
  const fs::path photos = folder_ / "photos";
  const fs::path masks = folder_ / "masks";
  ASSERT_TRUE(CreateFolders(photos).ok() && CreateFolders(masks).ok());
  ASSERT_TRUE(
      WriteImage(photos / view.name, ImageU8(width, height, 3, 90)).ok());
  const auto measured =
      MeasureHoldoutQuality(scene, photos, masks, cancellation_, pool_);
  ASSERT_TRUE(measured.ok()) << measured.status().message();
  ASSERT_TRUE(measured->has_value());
  EXPECT_EQ((*measured)->views.size(), 1u);

  ASSERT_TRUE(
      WriteLabels(masks / (view.name + ".png"), ImageU16(width, height, 1, 0))
          .ok());
  const auto nothing =
      MeasureHoldoutQuality(scene, photos, masks, cancellation_, pool_);
  ASSERT_TRUE(nothing.ok()) << nothing.status().message();
  EXPECT_FALSE(nothing->has_value());
}

TEST_F(EvaluationTest, ReportsFaultsOfTheTruth) {
  const WorkspaceScene scene = MakeScene();
  const View& view = truth_.cameras.test[0];
  ASSERT_TRUE(WriteImage(truth_.photos[view.name], ImageU8(5, 5, 3)).ok());
  const auto wrong_size = MeasureTestQuality(Context(scene));
  EXPECT_EQ(wrong_size.status().code(), StatusCode::kBadInput);
  EXPECT_THAT(wrong_size.status().message(),
              AllOf(HasSubstr(truth_.photos[view.name].string()),
                    HasSubstr("5 x 5"),
                    HasSubstr("96 x 72")));
  ASSERT_TRUE(
      WriteFileAtomic(truth_.masks[view.name][0].path, "no image").ok());
  EXPECT_FALSE(MeasureInstanceQuality(Context(scene), labels_).ok());
  const std::vector<int32_t> too_few(5, 0);
  EXPECT_FALSE(MeasureInstanceQuality(Context(scene), too_few).ok());
}

TEST_F(EvaluationTest, StopsWhenCancelled) {
  WorkspaceScene scene = MakeScene();
  cancellation_.Cancel();
  EXPECT_EQ(MeasureTestQuality(Context(scene)).status().code(),
            StatusCode::kInterrupted);
  scene.holdout = {scene.train.back()};
  const View& view = scene.holdout[0];
  ASSERT_TRUE(WriteImage(folder_ / view.name,
                         ImageU8(view.camera.width, view.camera.height, 3, 90))
                  .ok());
  EXPECT_EQ(MeasureHoldoutQuality(scene, folder_, {}, cancellation_, pool_)
                .status()
                .code(),
            StatusCode::kInterrupted);
}

TEST_F(EvaluationTest, NamesMatchByStemWhenNotExactly) {
  WorkspaceScene scene = MakeScene();
  for (View& view : scene.train) {
    view.name = fs::path("photos" / fs::path(view.name))
                    .replace_extension(".png")
                    .string();
  }
  scene.holdout = {scene.train.back()};
  scene.train.pop_back();
  const auto poses = AlignWithViews(scene, truth_.cameras.train, "truth");
  ASSERT_TRUE(poses.ok());
  EXPECT_EQ(poses->residuals.size(), 10u);
  EXPECT_EQ(poses->residuals[0].name, "frame_0.jpg");

  // A stem that two of our photos share fits neither.
  scene.train[0].name = "other/" + scene.train[1].name;
  const auto without = AlignWithViews(scene, truth_.cameras.train, "truth");
  ASSERT_TRUE(without.ok());
  EXPECT_EQ(without->residuals.size(), 8u);

  scene.train.resize(2);
  scene.holdout.clear();
  EXPECT_EQ(
      AlignWithViews(scene, truth_.cameras.train, "truth").status().code(),
      StatusCode::kBadInput);
}

TEST_F(EvaluationTest, ReportHasEveryKey) {
  EvaluationReport report;
  report.workspace = "w";
  nlohmann::json json = ToJson(report);
  for (const char* key : {"psnr",
                          "ssim",
                          "pose_rotation_deg",
                          "pose_translation",
                          "instance_miou",
                          "click_miou",
                          "text_miou",
                          "text_mbiou",
                          "text_box_miou",
                          "text_box_recall25",
                          "text_box_recall50",
                          "pq",
                          "view_consistency",
                          "box_miou",
                          "box_recall25",
                          "box_recall50"}) {
    ASSERT_TRUE(json.contains(key)) << key;
    EXPECT_TRUE(json[key].is_null()) << key;
  }
  const WorkspaceScene scene = MakeScene();
  report.poses = *AlignWithViews(scene, truth_.cameras.train, "truth");
  report.test = *MeasureTestQuality(Context(scene));
  report.instances = *MeasureInstanceQuality(Context(scene), labels_);
  json = ToJson(report);
  EXPECT_EQ(json["psnr_views"], "test");
  EXPECT_GT(json["psnr"], 40);
  EXPECT_LT(json["pose_rotation_deg"], 1e-3);
  EXPECT_GT(json["box_recall50"], 0.9);
  EXPECT_GT(json["pq"], 0.9);
  EXPECT_EQ(json["panoptic"]["views"].size(), 3u);
  EXPECT_TRUE(json["text_miou"].is_null());
  EXPECT_TRUE(json["objects"][0]["text_iou"].is_null());
  EXPECT_EQ(json["objects"].size(), 3u);
  EXPECT_EQ(json["objects"][0]["instance"], 1);
  std::ostringstream table;
  PrintTable(report, table);
  EXPECT_NE(table.str().find("instance mIoU"), std::string::npos);
  EXPECT_NE(table.str().find("ball 3"), std::string::npos);

  // Names are cut between characters: 24 of these have 48 bytes.
  std::string name;
  for (int i = 0; i < 24; ++i) name += "\u00e4";
  report.instances->objects[0].label = name + name;
  std::ostringstream umlauts;
  PrintTable(report, umlauts);
  EXPECT_NE(umlauts.str().find("  " + name + "  "), std::string::npos);
}

TEST_F(EvaluationTest, ReportSaysWhichTestViewsWereGiven) {
  const auto table = [this](const WorkspaceScene& scene, nlohmann::json* json) {
    EvaluationReport report;
    const auto test = MeasureTestQuality(Context(scene));
    EXPECT_TRUE(test.ok()) << test.status().message();
    if (test.ok()) report.test = *test;
    *json = ToJson(report);
    std::ostringstream text;
    PrintTable(report, text);
    return text.str();
  };
  nlohmann::json json;
  WorkspaceScene scene = MakeScene();
  EXPECT_NE(table(scene, &json).find("photos never given, 3 views"),
            std::string::npos);
  EXPECT_EQ(json["test_trained"], 0);
  EXPECT_TRUE(json["test_views"][0]["given_as"].is_null());

  scene.train[0].name = "all/test_0.png";
  scene.train[1].name = "test_4.jpg";
  scene.holdout = {scene.train[2]};
  scene.holdout[0].name = "test_8.png";
  EXPECT_NE(
      table(scene, &json)
          .find("3 views, of them 2 trained on, 1 given as holdout photos"),
      std::string::npos);
  EXPECT_EQ(json["test_trained"], 2);
  EXPECT_EQ(json["test_holdout"], 1);
  EXPECT_EQ(json["test_views"][0]["given_as"], "train");
  EXPECT_EQ(json["test_views"][2]["given_as"], "holdout");

  // A training view of the truth may have the name of a test view, as in
  // NeRF-synthetic. Its photograph is not that of the test view.
  truth_.cameras.train[0].name = "test_0.png";
  EXPECT_EQ(FindTestViewUses(scene, truth_)[0], TestViewUse::kNone);
  truth_.cameras.train[0] = truth_.cameras.test[0];
  EXPECT_EQ(FindTestViewUses(scene, truth_)[0], TestViewUse::kTraining);
}

}  // namespace
}  // namespace freegs::stages
