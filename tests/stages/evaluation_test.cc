// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation.h"

#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/files.h"
#include "core/image_io.h"
#include "core/random.h"
#include "stages/evaluation_report.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

// Three balls of Gaussians in a row, the true objects 1, 2 and 3, seen from
// all around.
class EvaluationTest : public testing::Test {
 protected:
  static constexpr int kPerBall = 300;
  static constexpr double kRadius = 0.5;
  static constexpr double kSigma = 0.06;  // Boxes reach one sigma further.

  void SetUp() override {
    folder_ = temporary_.path();
    ASSERT_TRUE(CreateFolders(folder_ / "test/images").ok());
    ASSERT_TRUE(CreateFolders(folder_ / "gt/instance").ok());
    MakeBalls();
    truth_.folder = folder_;
    for (int i = 0; i < 10; ++i) {
      const std::string number = std::to_string(i);
      truth_.cameras.train.push_back(
          MakeView("frame_" + number + ".jpg", 0.6 * i));
      if (i % 4 == 0) {
        truth_.cameras.test.push_back(
            MakeView("test_" + number + ".png", 0.6 * i + 0.3));
      }
    }
    for (const View& view : truth_.cameras.test) {
      const splat::RenderedView picture = splat::RenderView(
          true_model_, view.camera, view.cam_from_world, {}, pool_);
      ASSERT_TRUE(WriteImage(truth_.TestPhoto(view), ToU8(picture.color)).ok());
      const Image<int32_t> labels = splat::RenderLabels(
          true_model_, view.camera, view.cam_from_world, {}, pool_, labels_);
      ImageU16 ids(labels.width(), labels.height(), 1);
      for (size_t i = 0; i < ids.size(); ++i) {
        ids.data()[i] = static_cast<uint16_t>(labels.data()[i] + 1);
      }
      ASSERT_TRUE(WriteLabels(truth_.InstanceMap(view), ids).ok());
    }
  }

  void MakeBalls() {
    true_model_.Resize(3 * kPerBall);
    for (int ball = 0; ball < 3; ++ball) {
      TrueObject object;
      object.id = ball + 1;
      object.label = "ball " + std::to_string(ball + 1);
      const Vector3d centre(1.5 * (ball - 1), 0, 0);
      object.aabb = {centre - Vector3d::Constant(kRadius + kSigma),
                     centre + Vector3d::Constant(kRadius + kSigma)};
      truth_.objects.push_back(object);
      for (int k = 0; k < kPerBall; ++k) {
        const size_t i = static_cast<size_t>(ball) * kPerBall + k;
        RandomStream random(1, i);
        const Vector3d direction(
            random.Normal(), random.Normal(), random.Normal());
        const Vector3d mean = centre + kRadius * direction.normalized();
        for (int axis = 0; axis < 3; ++axis) {
          true_model_.means[3 * i + axis] = static_cast<float>(mean[axis]);
          true_model_.log_scales[3 * i + axis] =
              static_cast<float>(std::log(kSigma));
          true_model_.sh_dc[3 * i + axis] =
              static_cast<float>(2 * random.Uniform() - 1);
        }
        true_model_.rotations[4 * i] = 1;
        true_model_.opacity_logits[i] = 4;
        labels_.push_back(ball);
      }
    }
  }

  static View MakeView(const std::string& name, double angle) {
    const Vector3d eye(5 * std::cos(angle),
                       5 * std::sin(angle),
                       1 + 0.5 * std::sin(3 * angle));
    const Vector3d z = -eye.normalized();
    const Vector3d x = z.cross(Vector3d::UnitZ()).normalized();
    Eigen::Matrix3d rotation;
    rotation << x.transpose(), z.cross(x).transpose(), z.transpose();
    View view;
    view.name = name;
    view.camera = {96, 72, 90, 90, 48, 36};
    view.cam_from_world.rotation = Eigen::Quaterniond(rotation);
    view.cam_from_world.translation = -rotation * eye;
    return view;
  }

  // The truth as a reconstruction in a world of its own would have it.
  WorkspaceScene MakeScene() const {
    const Sim3d scene_from_truth = Inverse(truth_from_scene_);
    WorkspaceScene scene;
    scene.model = true_model_;
    for (size_t i = 0; i < scene.model.size(); ++i) {
      const Vector3d mean =
          scene_from_truth * Vector3d(true_model_.means[3 * i],
                                      true_model_.means[3 * i + 1],
                                      true_model_.means[3 * i + 2]);
      for (int axis = 0; axis < 3; ++axis) {
        scene.model.means[3 * i + axis] = static_cast<float>(mean[axis]);
        scene.model.log_scales[3 * i + axis] +=
            static_cast<float>(std::log(scene_from_truth.scale));
      }
    }
    for (const View& view : truth_.cameras.train) {
      View moved = view;
      moved.cam_from_world =
          TransformCamera(scene_from_truth, view.cam_from_world);
      scene.train.push_back(moved);
    }
    return scene;
  }

  ThreadPool pool_{2};
  CancellationToken cancellation_;
  TemporaryFolder temporary_;
  fs::path folder_;
  GroundTruth truth_;
  splat::GaussianModel true_model_;
  std::vector<int32_t> labels_;
  Sim3d truth_from_scene_{0.4,
                          Eigen::Quaterniond(Eigen::AngleAxisd(
                              1.1, Vector3d(1, 2, 3).normalized())),
                          {3, -2, 1}};
};

TEST_F(EvaluationTest, APerfectSceneIsPerfect) {
  const WorkspaceScene scene = MakeScene();
  const auto poses = AlignWithTruth(scene, truth_);
  ASSERT_TRUE(poses.ok()) << poses.status().message();
  EXPECT_EQ(poses->residuals.size(), 10u);
  EXPECT_LT(poses->max_rotation_deg, 1e-5);
  EXPECT_LT(poses->max_centre, 1e-9);
  const Sim3d found = poses->target_from_source;
  EXPECT_NEAR(found.scale, 0.4, 1e-9);

  const auto test =
      MeasureTestQuality(scene, truth_, found, cancellation_, pool_);
  ASSERT_TRUE(test.ok() && test->has_value());
  EXPECT_EQ((*test)->views.size(), 3u);
  EXPECT_GT((*test)->psnr, 45);
  EXPECT_GT((*test)->ssim, 0.995);

  const auto instances = MeasureInstanceQuality(
      scene, labels_, truth_, found, {}, cancellation_, pool_);
  ASSERT_TRUE(instances.ok() && instances->has_value());
  const InstanceQuality& quality = **instances;
  EXPECT_GT(*quality.instance_miou, 0.97);
  EXPECT_GT(*quality.click_miou, 0.97);
  EXPECT_GT(*quality.box_miou, 0.9);
  EXPECT_EQ(*quality.box_recall50, 1);
  ASSERT_EQ(quality.objects.size(), 3u);
  EXPECT_EQ(quality.objects[1].label, "ball 2");
  EXPECT_EQ(quality.objects[1].instance, 1);
  EXPECT_EQ(quality.objects[1].num_views, 3);
}

TEST_F(EvaluationTest, MergedObjectsCost) {
  const WorkspaceScene scene = MakeScene();
  std::vector<int32_t> merged = labels_;
  for (int32_t& label : merged) label = label == 2 ? 1 : label;
  const auto instances = MeasureInstanceQuality(
      scene, merged, truth_, truth_from_scene_, {}, cancellation_, pool_);
  ASSERT_TRUE(instances.ok() && instances->has_value());
  const InstanceQuality& quality = **instances;
  EXPECT_GT(*quality.objects[0].instance_iou, 0.95);
  EXPECT_LT(*quality.objects[1].instance_iou, 0.9);
  EXPECT_LT(*quality.objects[2].click_iou, 0.9);
  EXPECT_NEAR(*quality.objects[2].box_iou, 0.4, 0.1);
  EXPECT_EQ(*quality.box_recall25, 1);
  EXPECT_NEAR(*quality.box_recall50, 1.0 / 3, 1e-9);
}

TEST_F(EvaluationTest, WithoutInstancesEverythingIsMissed) {
  const WorkspaceScene scene = MakeScene();
  const std::vector<int32_t> none(labels_.size(), -1);
  const auto instances = MeasureInstanceQuality(
      scene, none, truth_, truth_from_scene_, {}, cancellation_, pool_);
  ASSERT_TRUE(instances.ok() && instances->has_value());
  EXPECT_EQ(*(*instances)->instance_miou, 0);
  EXPECT_EQ(*(*instances)->click_miou, 0);
  EXPECT_EQ(*(*instances)->box_miou, 0);
  EXPECT_EQ((*instances)->objects[0].instance, -1);
}

TEST_F(EvaluationTest, WithoutTruthThereIsNothing) {
  const WorkspaceScene scene = MakeScene();
  for (const View& view : truth_.cameras.test) {
    fs::remove(truth_.TestPhoto(view));
    fs::remove(truth_.InstanceMap(view));
  }
  const auto test = MeasureTestQuality(
      scene, truth_, truth_from_scene_, cancellation_, pool_);
  ASSERT_TRUE(test.ok());
  EXPECT_FALSE(test->has_value());
  const auto instances = MeasureInstanceQuality(
      scene, labels_, truth_, truth_from_scene_, {}, cancellation_, pool_);
  ASSERT_TRUE(instances.ok());
  EXPECT_FALSE(instances->has_value());
  const auto holdout = MeasureHoldoutQuality(scene, folder_, pool_);
  ASSERT_TRUE(holdout.ok());
  EXPECT_FALSE(holdout->has_value());
}

TEST_F(EvaluationTest, ReportsFaultsOfTheTruth) {
  const WorkspaceScene scene = MakeScene();
  const View& view = truth_.cameras.test[0];
  ASSERT_TRUE(WriteImage(truth_.TestPhoto(view), ImageU8(5, 5, 3)).ok());
  const auto wrong_size = MeasureTestQuality(
      scene, truth_, truth_from_scene_, cancellation_, pool_);
  EXPECT_EQ(wrong_size.status().code(), StatusCode::kBadInput);
  ASSERT_TRUE(WriteFileAtomic(truth_.InstanceMap(view), "no image").ok());
  EXPECT_FALSE(
      MeasureInstanceQuality(
          scene, labels_, truth_, truth_from_scene_, {}, cancellation_, pool_)
          .ok());
  const std::vector<int32_t> too_few(5, 0);
  EXPECT_FALSE(
      MeasureInstanceQuality(
          scene, too_few, truth_, truth_from_scene_, {}, cancellation_, pool_)
          .ok());
}

TEST_F(EvaluationTest, StopsWhenCancelled) {
  const WorkspaceScene scene = MakeScene();
  cancellation_.Cancel();
  EXPECT_EQ(
      MeasureTestQuality(scene, truth_, truth_from_scene_, cancellation_, pool_)
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
  const auto poses = AlignWithTruth(scene, truth_);
  ASSERT_TRUE(poses.ok());
  EXPECT_EQ(poses->residuals.size(), 10u);
  EXPECT_EQ(poses->residuals[0].name, "frame_0.jpg");

  scene.train.resize(2);
  scene.holdout.clear();
  EXPECT_EQ(AlignWithTruth(scene, truth_).status().code(),
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
                          "box_miou",
                          "box_recall25",
                          "box_recall50"}) {
    ASSERT_TRUE(json.contains(key)) << key;
    EXPECT_TRUE(json[key].is_null()) << key;
  }
  const WorkspaceScene scene = MakeScene();
  report.poses = *AlignWithTruth(scene, truth_);
  report.test = *MeasureTestQuality(
      scene, truth_, truth_from_scene_, cancellation_, pool_);
  report.instances = *MeasureInstanceQuality(
      scene, labels_, truth_, truth_from_scene_, {}, cancellation_, pool_);
  json = ToJson(report);
  EXPECT_EQ(json["psnr_views"], "test");
  EXPECT_GT(json["psnr"], 40);
  EXPECT_LT(json["pose_rotation_deg"], 1e-3);
  EXPECT_GT(json["box_recall50"], 0.9);
  EXPECT_TRUE(json["text_miou"].is_null());
  EXPECT_EQ(json["objects"].size(), 3u);
  EXPECT_EQ(json["objects"][0]["instance"], 1);
  std::ostringstream table;
  PrintTable(report, table);
  EXPECT_NE(table.str().find("instance mIoU"), std::string::npos);
  EXPECT_NE(table.str().find("ball 3"), std::string::npos);
}

}  // namespace
}  // namespace freegs::stages
