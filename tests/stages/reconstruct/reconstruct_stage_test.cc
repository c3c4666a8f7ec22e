// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/reconstruct_stage.h"

#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "splat/scene/ply_io.h"
#include "splat/scene/spz_format.h"
#include "stages/scene/training_scene.h"
#include "tests/stages/moved_world.h"
#include "tests/stages/reconstruct/reconstruct_fixture.h"
#include "tests/stages/renamed_photo.h"
#include "tests/stages/scene_outlook_of.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using ReconstructStageTest = ReconstructFixture;

TEST_F(ReconstructStageTest, AllHoldoutPhotosReport) {
  ASSERT_TRUE(Run(Auto(), "auto").ok()) << log_;
  const nlohmann::json metrics = Metrics("auto");
  const nlohmann::json& views = metrics["holdout_views"];
  ASSERT_EQ(views.size(), 2u);
  EXPECT_EQ(views[0]["name"], "photo0.png");
  EXPECT_EQ(views[1]["name"], "photo5.png");
  for (const std::string figure : {"psnr", "ssim"}) {
    EXPECT_NEAR(
        metrics["holdout_" + figure].get<double>(),
        (views[0][figure].get<double>() + views[1][figure].get<double>()) / 2,
        1e-9);
  }
  EXPECT_TRUE(fs::exists(workspace_ / "auto" / "holdout" / "photo5.png"));
}

TEST_F(ReconstructStageTest, ForetellsWhatItNeedsAndMakes) {
  ThreadPool pool(2);
  pipeline::StageContext context;
  context.workspace = workspace_;
  context.pool = &pool;
  const auto stage = MakeReconstructStage(Short(), 3);
  pipeline::SceneOutlook scene;
  EXPECT_FALSE(stage->Foretell(context, false, &scene).known());
  EXPECT_EQ(scene.gaussians, 0);
  scene = SceneOutlookOf(8, 80, 60);
  const pipeline::StageNeed need = stage->Foretell(context, false, &scene);
  EXPECT_GT(need.memory_bytes, pipeline::kProgramMemory);
  EXPECT_NE(need.advice, "");
  EXPECT_EQ(scene.gaussians, 500);
  // When it is done, the number of Gaussians is that of the file.
  fs::create_directories(workspace_ / "reconstruct");
  ASSERT_TRUE(
      splat::WritePly(workspace_ / "reconstruct" / "point_cloud.ply", truth_)
          .ok());
  EXPECT_EQ(stage->Foretell(context, true, &scene).memory_bytes,
            need.memory_bytes);
  EXPECT_EQ(scene.gaussians, 80);
}

TEST_F(ReconstructStageTest, WritesTheContract) {
  const Status status = Run(Short(), "out");
  ASSERT_TRUE(status.ok()) << status.message();
  const nlohmann::json metrics =
      nlohmann::json::parse(Bytes("out/metrics.json"));
  // Few steps are left after the last of four restarts.
  EXPECT_GT(metrics["holdout_psnr"].get<double>(), 15);
  EXPECT_GT(metrics["holdout_ssim"].get<double>(), 0.4);
  EXPECT_GT(metrics["holdout_tile_pairs"].get<int>(), 0);
  EXPECT_GT(metrics["trained_psnr"].get<double>(), 15);
  EXPECT_EQ(metrics["iterations"], 200);
  EXPECT_GT(metrics["peak_memory_bytes"].get<int64_t>(), 0);
  const auto model = splat::ReadPly(workspace_ / "out" / "point_cloud.ply");
  ASSERT_TRUE(model.ok());
  EXPECT_EQ(metrics["num_gaussians"], model->model.size());
  for (const char* name : {"photo0.png", "photo5.png"}) {
    EXPECT_TRUE(fs::exists(workspace_ / "out" / "holdout" / name));
  }
  const std::string csv = Bytes("out/progress.csv");
  EXPECT_EQ(csv.rfind("iteration,seconds,loss,num_gaussians,holdout_psnr\n", 0),
            0u);
  EXPECT_NE(csv.find("\n100,"), std::string::npos);
  EXPECT_FALSE(fs::is_empty(workspace_ / "out" / "checkpoints"));
}

TEST_F(ReconstructStageTest, RendersHaveTheNameOfTheirPhotoAmongAllPhotos) {
  // photo5.png is held out, photo5.jpg is not.
  RenamePhoto(workspace_, "photo4.png", "photo5.jpg");
  ReconstructStageOptions options;
  options.import = (workspace_ / "trained.ply").string();
  ASSERT_TRUE(splat::WritePly(options.import, truth_).ok());
  const Status status = Run(options, "out");
  ASSERT_TRUE(status.ok()) << status.message();
  const fs::path folder = workspace_ / "out" / "holdout";
  EXPECT_TRUE(fs::exists(folder / "photo5.png.png"));
  EXPECT_FALSE(fs::exists(folder / "photo5.png"));
  EXPECT_TRUE(fs::exists(folder / "photo0.png"));
}

TEST_F(ReconstructStageTest, ReportsTheCourseOfEachMethod) {
  for (const char* method : {"mini_splatting", "gradient", "none"}) {
    ReconstructStageOptions options = Short();
    options.densification = method;
    const Status status = Run(options, method);
    ASSERT_TRUE(status.ok()) << status.message();
    const nlohmann::json metrics =
        nlohmann::json::parse(Bytes(std::string(method) + "/metrics.json"));
    const bool mini = options.densification == "mini_splatting";
    EXPECT_EQ(metrics["densification"], method);
    EXPECT_EQ(metrics["importance_metric"].is_string(), mini);
    EXPECT_TRUE(metrics["recoveries"].is_array());
    EXPECT_TRUE(metrics["recoveries"].empty());
    ASSERT_TRUE(metrics["milestones"].is_array());
    EXPECT_LE(metrics["num_gaussians"].get<int>(), 500);
    ASSERT_EQ(metrics["milestones"].size(), mini ? 2u : 0u);
    const bool gradient = options.densification == "gradient";
    EXPECT_GT(metrics["holdout_psnr"].get<double>(), gradient ? 18 : 14);
    if (!mini) continue;
    // A short training does not start again from depth maps.
    EXPECT_EQ(metrics["milestones"][0]["event"], "simplification");
    EXPECT_EQ(metrics["milestones"][0]["iteration"], 100);
    EXPECT_GE(metrics["milestones"][0]["gaussians_before"],
              metrics["milestones"][0]["gaussians_after"]);
    EXPECT_EQ(metrics["milestones"][1]["event"], "pruning");
    EXPECT_EQ(metrics["milestones"][1]["gaussians_after"],
              metrics["num_gaussians"]);
  }
}

TEST_F(ReconstructStageTest, BudgetIsAutoOrANumber) {
  for (const char* budget :
       {"", "many", "-1", "1e5", "100 ", "0x10", "99999999999999999999"}) {
    ReconstructStageOptions options = Short();
    options.budget = budget;
    const Status status = Run(options, "out");
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument) << budget;
    EXPECT_NE(status.message().find("reconstruct.budget"), std::string::npos);
  }
  ReconstructStageOptions options = Short();
  options.iterations = 20;
  for (const char* budget : {"auto", "0", "40"}) {
    options.budget = budget;
    EXPECT_TRUE(Run(options, "out").ok()) << budget;
  }
}

TEST_F(ReconstructStageTest, TakesATrainedModel) {
  ReconstructStageOptions options;
  options.import = (workspace_ / "trained.ply").string();
  ASSERT_TRUE(splat::WritePly(options.import, truth_).ok());
  ASSERT_TRUE(Run(options, "out").ok());
  const nlohmann::json metrics =
      nlohmann::json::parse(Bytes("out/metrics.json"));
  // The photos are renderings of this very model.
  EXPECT_GT(metrics["holdout_psnr"].get<double>(), 50);
  EXPECT_EQ(metrics["num_gaussians"], truth_.size());
  EXPECT_TRUE(metrics.at("budget").is_null());
  EXPECT_TRUE(metrics.at("exposure_search").is_null());
}

TEST_F(ReconstructStageTest, SaysThatATrainedModelIsAntialiased) {
  ReconstructStageOptions options;
  options.import = (workspace_ / "trained.ply").string();
  ASSERT_TRUE(splat::WritePly(options.import, truth_).ok());
  for (const bool antialiased : {false, true}) {
    options.antialiased = antialiased;
    ASSERT_TRUE(Run(options, "out").ok());
    const auto model = splat::ReadPly(workspace_ / "out" / "point_cloud.ply");
    ASSERT_TRUE(model.ok()) << model.status().message();
    EXPECT_EQ(model->model.antialiased, antialiased);
  }
}

// Those beyond the cache are read again, and here one has gone by then.
TEST_F(ReconstructStageTest, HoldoutPhotosKeepToTheCache) {
  ReconstructStageOptions options;
  options.import = (workspace_ / "trained.ply").string();
  ASSERT_TRUE(splat::WritePly(options.import, truth_).ok());
  const fs::path photo = workspace_ / "undistort" / "images" / "photo5.png";
  on_log_ = [&](const std::string& line) {
    if (line.starts_with("imported")) fs::remove(photo);
  };
  options.image_cache_gb = 1e-6;
  const Status status = Run(options, "out");
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), testing::HasSubstr("photo5.png"));
}

TEST_F(ReconstructStageTest, TakesACompressedModel) {
  ReconstructStageOptions options;
  options.import = (workspace_ / "trained.SPZ").string();
  ASSERT_TRUE(splat::WriteSpz(options.import, truth_).ok());
  ASSERT_TRUE(Run(options, "out").ok());
  const nlohmann::json metrics =
      nlohmann::json::parse(Bytes("out/metrics.json"));
  EXPECT_GT(metrics["holdout_psnr"].get<double>(), 35);

  // Nothing tells from where its positions count in a world far away.
  MoveWorld(workspace_, 1, Eigen::Vector3d(3, -5, 2) * 1e5);
  const Status far = Run(options, "far");
  EXPECT_EQ(far.code(), StatusCode::kBadInput);
  EXPECT_THAT(far.message(), testing::HasSubstr("import the .ply"));
}

TEST_F(ReconstructStageTest, ForetellsWhatAnImportNeeds) {
  ThreadPool pool(2);
  pipeline::StageContext context;
  context.workspace = workspace_;
  context.pool = &pool;
  ReconstructStageOptions options;
  options.import = (workspace_ / "trained.spz").string();
  pipeline::SceneOutlook scene = SceneOutlookOf(8, 80, 60);
  const pipeline::StageNeed unread =
      MakeReconstructStage(options, 3)->Foretell(context, false, &scene);
  EXPECT_FALSE(unread.known());
  EXPECT_THAT(unread.unknown_reason, testing::HasSubstr("trained.spz"));
  ASSERT_TRUE(splat::WriteSpz(options.import, truth_).ok());
  EXPECT_TRUE(MakeReconstructStage(options, 3)
                  ->Foretell(context, false, &scene)
                  .known());
  EXPECT_EQ(scene.gaussians, static_cast<int64_t>(truth_.size()));
}

TEST_F(ReconstructStageTest, RefusesModelsOfOtherFormats) {
  ReconstructStageOptions options;
  options.import = (workspace_ / "scene.splat").string();
  ASSERT_TRUE(splat::WritePly(options.import, truth_).ok());
  const Status status = Run(options, "out");
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(),
              testing::HasSubstr("scene.splat: .ply and .spz can be imported"));
}

TEST_F(ReconstructStageTest, SameQualityInAnyUnitAndPlace) {
  ASSERT_TRUE(Run(Short(), "plain").ok());
  const nlohmann::json expected = Metrics("plain");
  double scale = 1;
  for (const double step : {1e-3, 1e7}) {
    MoveWorld(workspace_, step, Eigen::Vector3d::Zero());
    scale *= step;
    const Status status = Run(Short(), "scaled");
    ASSERT_TRUE(status.ok()) << status.message();
    EXPECT_EQ(Metrics("scaled")["holdout_psnr"], expected["holdout_psnr"]);
    EXPECT_EQ(Metrics("scaled")["num_gaussians"], expected["num_gaussians"]);
  }
  MoveWorld(workspace_, 1, Eigen::Vector3d(3, -5, 2) * 1e5 * scale);
  ASSERT_TRUE(Run(Short(), "far").ok());
  EXPECT_EQ(Metrics("far")["holdout_psnr"], expected["holdout_psnr"]);
  const auto model = splat::ReadPly(workspace_ / "far" / "point_cloud.ply");
  ASSERT_TRUE(model.ok());
  EXPECT_NEAR(model->offset.x(), 3e5 * scale, 10 * scale);
  EXPECT_THAT(log_, testing::HasSubstr("comment offset"));
}

TEST_F(ReconstructStageTest, RefusesAModelThatNoPhotoShows) {
  ReconstructStageOptions options = Short();
  options.import = (workspace_ / "elsewhere.ply").string();
  splat::GaussianModel elsewhere = truth_;
  for (float& x : elsewhere.means) x += 1e4f;
  ASSERT_TRUE(splat::WritePly(options.import, elsewhere).ok());
  const Status status = Run(options, "out");
  EXPECT_EQ(status.code(), StatusCode::kUnusableResult);
  EXPECT_THAT(status.message(), testing::HasSubstr("is visible"));
}

TEST_F(ReconstructStageTest, PosesThatDoNotFitTheHoldoutAreTold) {
  ASSERT_TRUE(Run(Short(), "good").ok()) << log_;
  EXPECT_THAT(log_, testing::Not(testing::HasSubstr("lie beside")));
  const nlohmann::json views = Metrics("good")["holdout_views"];
  EXPECT_LT(views[0]["displacement_px"], 1);
  // The holdout cameras are turned by some six of 80 pixels.
  const fs::path folder = workspace_ / "undistort" / "sparse";
  StatusOr<sfm::Reconstruction> sparse = sfm::ReadModel(folder);
  ASSERT_TRUE(sparse.ok()) << sparse.status().message();
  for (size_t k = 0; k < sparse->images.size(); k += 5) {
    Rigid3d turn;
    turn.rotation = Eigen::AngleAxisd(6 / sparse->cameras[0].FocalX(),
                                      Eigen::Vector3d::UnitY());
    sparse->images[k].cam_from_world = turn * sparse->images[k].cam_from_world;
  }
  ASSERT_TRUE(sfm::WriteModel(folder, *sparse).ok());
  ASSERT_TRUE(Run(Short(), "turned").ok()) << log_;
  EXPECT_THAT(
      log_, testing::HasSubstr("2 of 2 photos kept from training lie beside"));
  // The measurement of trained photos comes after that.
  cancel_on_ = "lie beside";
  EXPECT_EQ(Run(Short(), "stopped").code(), StatusCode::kInterrupted);
}

TEST_F(ReconstructStageTest, MeasuringCanBeStopped) {
  ReconstructStageOptions options;
  options.import = (workspace_ / "trained.ply").string();
  ASSERT_TRUE(splat::WritePly(options.import, truth_).ok());
  cancel_on_ = "imported";
  EXPECT_EQ(Run(options, "out").code(), StatusCode::kInterrupted);
  EXPECT_FALSE(fs::exists(workspace_ / "out" / "holdout"));
  EXPECT_FALSE(fs::exists(workspace_ / "out" / "metrics.json"));
}

TEST_F(ReconstructStageTest, ErrorsNameTheFile) {
  fs::remove(workspace_ / "undistort" / "images" / "photo3.png");
  const Status missing = Run(Short(), "out");
  EXPECT_EQ(missing.code(), StatusCode::kBadInput);
  EXPECT_NE(missing.message().find("photo3.png"), std::string::npos);
}

}  // namespace
}  // namespace freegs::stages
