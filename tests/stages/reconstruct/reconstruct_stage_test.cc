// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/reconstruct_stage.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "photos/photo_list.h"
#include "sfm/scene/model_io.h"
#include "splat/render/renderer.h"
#include "splat/scene/ply_io.h"
#include "splat/scene/spz_format.h"
#include "splat/train/checkpoint.h"
#include "stages/reconstruct/training_report.h"
#include "stages/scene/training_scene.h"
#include "tests/splat/test_scene.h"
#include "tests/stages/moved_world.h"
#include "tests/stages/scene_outlook_of.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// A workspace as undistort leaves it: ten small photos of a known model, two of
// them held out, and the model's centres as points.
class ReconstructStageTest : public testing::Test {
 protected:
  void SetUp() override {
    truth_ = splat::RandomSceneModel(80, 0, 33);
    ThreadPool pool(2);
    sfm::Reconstruction model;
    const Pinhole pinhole = splat::TestCamera(80, 60);
    sfm::Camera camera;
    camera.id = 1;
    camera.model = sfm::CameraModel::kPinhole;
    camera.width = pinhole.width;
    camera.height = pinhole.height;
    camera.params = {pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy};
    model.cameras.push_back(camera);
    photos::PhotoList photos;
    for (int k = 0; k < 10; ++k) {
      sfm::PosedImage image;
      image.id = k + 1;
      image.camera_id = 1;
      image.name = "photo" + std::to_string(k) + ".png";
      Rigid3d orbit;
      orbit.rotation = Eigen::Quaterniond(
          Eigen::AngleAxisd(0.1 * (k - 4.5), Eigen::Vector3d::UnitY()));
      image.cam_from_world = splat::TestPose() * orbit;
      const splat::RenderedView rendered = splat::RenderView(
          truth_, pinhole, image.cam_from_world, splat::RenderOptions(), pool);
      fs::create_directories(workspace_ / "undistort" / "images");
      ASSERT_TRUE(WriteImage(workspace_ / "undistort" / "images" / image.name,
                             ToU8(rendered.color))
                      .ok());
      model.images.push_back(image);
      photos::Photo photo;
      photo.file = photo.name = image.name;
      photo.width = pinhole.width;
      photo.height = pinhole.height;
      photo.camera_group = 0;
      photo.split = k % 5 == 0 ? photos::PhotoSplit::kHoldout
                               : photos::PhotoSplit::kTrain;
      photos.photos.push_back(photo);
    }
    for (size_t i = 0; i < truth_.size(); ++i) {
      sfm::Point3D point;
      point.id = i + 1;
      point.xyz = Eigen::Vector3d(truth_.means[3 * i],
                                  truth_.means[3 * i + 1],
                                  truth_.means[3 * i + 2]);
      point.rgb = {128, 128, 128};
      model.points3d.push_back(point);
    }
    ASSERT_TRUE(
        sfm::WriteModel(workspace_ / "undistort" / "sparse", model).ok());
    fs::create_directories(workspace_ / "ingest");
    ASSERT_TRUE(
        photos::WritePhotoList(workspace_ / "ingest" / "images.json", photos)
            .ok());
  }
  // Runs the stage into workspace / folder. Cancels at the first report of
  // progress at or after `cancel_at` iterations.
  Status Run(const ReconstructStageOptions& options,
             const std::string& folder,
             bool resuming = false,
             double cancel_at = 1e9) {
    ThreadPool pool(2);
    CancellationToken cancellation;
    pipeline::StageContext context;
    context.workspace = workspace_;
    context.output = workspace_ / folder;
    context.preview = preview_;
    context.resuming = resuming;
    context.pool = &pool;
    context.cancellation = &cancellation;
    context.progress = [&](const Progress& progress) {
      if (progress.done >= cancel_at) cancellation.Cancel();
    };
    context.log = [&](pipeline::LogLevel, const std::string& line) {
      log_ += line + "\n";
      if (!cancel_on_.empty() && line.find(cancel_on_) != std::string::npos) {
        cancellation.Cancel();
      }
    };
    fs::create_directories(context.output);
    const auto stage = MakeReconstructStage(options, 3);
    for (const fs::path& input : stage->Inputs(context)) {
      EXPECT_TRUE(fs::exists(input.is_absolute() ? input : workspace_ / input))
          << input;
    }
    return stage->Run(context);
  }

  static ReconstructStageOptions Short() {
    ReconstructStageOptions options;
    options.iterations = 200;
    options.densify_interval = 20;
    options.budget = "500";
    options.exposure = "off";
    options.holdout_interval = 100;
    return options;
  }

  // A search about exposure.
  static ReconstructStageOptions Auto() {
    ReconstructStageOptions options = Short();
    options.sh_degree = 1;
    options.exposure = "auto";
    return options;
  }

  nlohmann::json Metrics(const std::string& folder) const {
    return nlohmann::json::parse(Bytes(folder + "/metrics.json"));
  }

  std::string Bytes(const std::string& file) const {
    StatusOr<std::string> content = ReadFile(workspace_ / file);
    EXPECT_TRUE(content.ok()) << content.status().message();
    return content.ok() ? *content : std::string();
  }

  const TemporaryFolder temporary_;
  const fs::path workspace_ = temporary_.path();
  fs::path preview_;
  std::string log_;        // Of all runs.
  std::string cancel_on_;  // Text of the log line to cancel at, if any.
  splat::GaussianModel truth_;
};

TEST_F(ReconstructStageTest, PhotosThatChooseDoNotReport) {
  ASSERT_TRUE(Run(Auto(), "auto").ok()) << log_;
  const nlohmann::json metrics = Metrics("auto");
  const nlohmann::json& views = metrics["holdout_views"];
  ASSERT_EQ(views.size(), 2u);
  EXPECT_EQ(views[0]["name"], "photo0.png");
  EXPECT_EQ(views[0]["choosing"], false);
  EXPECT_EQ(views[1]["name"], "photo5.png");
  EXPECT_EQ(views[1]["choosing"], true);
  EXPECT_EQ(metrics["holdout_psnr"], views[0]["psnr"]);
  EXPECT_EQ(metrics["holdout_ssim"], views[0]["ssim"]);
  EXPECT_TRUE(fs::exists(workspace_ / "auto" / "holdout" / "photo5.png"));
}

TEST(SplitHoldout, EverySecondByNameChooses) {
  std::vector<View> views(5);
  const std::string names = "debac";
  for (size_t i = 0; i < 5; ++i) views[i].name = names.substr(i, 1);
  const HoldoutSplit split = SplitHoldout(views);
  const auto joined = [](const std::vector<View>& part) {
    std::string text;
    for (const View& view : part) text += view.name;
    return text;
  };
  EXPECT_EQ(joined(split.reporting), "ace");
  EXPECT_EQ(joined(split.choosing), "bd");
  EXPECT_EQ(SplitHoldout({views[0]}).choosing.size(), 0u);
  EXPECT_EQ(SplitHoldout({views[0]}).reporting.size(), 1u);
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

TEST_F(ReconstructStageTest, ReportsTheCourseOfEachMethod) {
  for (const char* method : {"mini_splatting", "gradient", "none"}) {
    ReconstructStageOptions options = Short();
    options.densification = method;
    options.depth_reinit = "always";
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
    ASSERT_EQ(metrics["milestones"].size(), mini ? 4u : 0u);
    const bool gradient = options.densification == "gradient";
    EXPECT_GT(metrics["holdout_psnr"].get<double>(), gradient ? 18 : 14);
    if (!mini) continue;
    EXPECT_EQ(metrics["milestones"][2]["event"], "simplification");
    EXPECT_EQ(metrics["milestones"][2]["iteration"], 100);
    EXPECT_GE(metrics["milestones"][2]["gaussians_before"],
              metrics["milestones"][2]["gaussians_after"]);
    EXPECT_EQ(metrics["milestones"][3]["gaussians_after"],
              metrics["num_gaussians"]);
  }
}

TEST_F(ReconstructStageTest, ShortTrainingsKeepTheirModelUnlessTold) {
  for (const char* depth_reinit : {"auto", "never"}) {
    ReconstructStageOptions options = Short();
    options.depth_reinit = depth_reinit;
    ASSERT_TRUE(Run(options, depth_reinit).ok());
    const nlohmann::json passed = Metrics(depth_reinit)["milestones"];
    ASSERT_EQ(passed.size(), 2u);
    EXPECT_EQ(passed[0]["event"], "simplification");
    EXPECT_EQ(passed[1]["event"], "pruning");
  }
}

TEST_F(ReconstructStageTest, ReportsTheSearchAboutExposure) {
  const Status status = Run(Auto(), "out");
  ASSERT_TRUE(status.ok()) << status.message();
  const nlohmann::json metrics = Metrics("out");
  EXPECT_EQ(metrics["budget"], 500);
  const nlohmann::json& search = metrics["exposure_search"];
  ASSERT_TRUE(search.is_object());
  EXPECT_FALSE(search["learn"].get<bool>());
  for (const char* trial : {"without", "with"}) {
    EXPECT_GT(search[trial]["psnr"].get<double>(), 10);
    EXPECT_GT(search[trial]["psnr_fitted"].get<double>(), 10);
  }
  EXPECT_GT(metrics["holdout_psnr_fitted"].get<double>(), 15);
  EXPECT_THAT(log_, testing::HasSubstr("exposure of each photo is not learnt"));
  // The model is the one of a training without a search.
  ReconstructStageOptions options = Auto();
  options.exposure = "off";
  ASSERT_TRUE(Run(options, "off").ok());
  EXPECT_TRUE(Metrics("off")["exposure_search"].is_null());
  EXPECT_EQ(Bytes("off/point_cloud.ply"), Bytes("out/point_cloud.ply"));
  options.exposure = "on";
  ASSERT_TRUE(Run(options, "on").ok());
  EXPECT_NE(Bytes("on/point_cloud.ply"), Bytes("out/point_cloud.ply"));
}

TEST_F(ReconstructStageTest, StoppedWhileOrAfterSearching) {
  ASSERT_TRUE(Run(Auto(), "whole").ok());
  cancel_on_ = "exposure of each photo";
  EXPECT_EQ(Run(Auto(), "parts").code(), StatusCode::kInterrupted);
  cancel_on_.clear();
  EXPECT_EQ(Run(Auto(), "parts", true, 50).code(), StatusCode::kInterrupted);
  log_.clear();
  ASSERT_TRUE(Run(Auto(), "parts", true).ok());
  EXPECT_THAT(log_, testing::Not(testing::HasSubstr("exposure of each")));
  EXPECT_EQ(Bytes("whole/point_cloud.ply"), Bytes("parts/point_cloud.ply"));
  EXPECT_EQ(Metrics("whole")["exposure_search"],
            Metrics("parts")["exposure_search"]);
}

TEST_F(ReconstructStageTest, NothingIsSearchedForWithoutHoldout) {
  const fs::path list = workspace_ / "ingest" / "images.json";
  StatusOr<photos::PhotoList> photos = photos::ReadPhotoList(list);
  ASSERT_TRUE(photos.ok());
  for (photos::Photo& photo : photos->photos) {
    photo.split = photos::PhotoSplit::kTrain;
  }
  ASSERT_TRUE(photos::WritePhotoList(list, *photos).ok());
  const Status status = Run(Auto(), "all");
  ASSERT_TRUE(status.ok()) << status.message();
  const nlohmann::json metrics = Metrics("all");
  EXPECT_TRUE(metrics.at("exposure_search").is_null());
  EXPECT_TRUE(metrics.at("holdout_psnr").is_null());
  EXPECT_TRUE(metrics.at("holdout_psnr_fitted").is_null());
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

TEST_F(ReconstructStageTest, ATrainingThatIsLookedAtHasTheSameResult) {
  ASSERT_TRUE(Run(Short(), "alone").ok());
  preview_ = workspace_ / "preview.jpg";
  ASSERT_TRUE(Run(Short(), "seen").ok());
  const StatusOr<ImageU8> picture = ReadRgb(preview_);
  ASSERT_TRUE(picture.ok()) << picture.status().message();
  EXPECT_EQ(picture->width(), 80);
  EXPECT_EQ(ReadText(workspace_ / "seen" / "point_cloud.ply"),
            ReadText(workspace_ / "alone" / "point_cloud.ply"));
}

TEST_F(ReconstructStageTest, InterruptedAndResumedGivesTheSameBytes) {
  ASSERT_TRUE(Run(Short(), "whole").ok());
  EXPECT_EQ(Run(Short(), "parts", false, 50).code(), StatusCode::kInterrupted);
  EXPECT_EQ(Run(Short(), "parts", true, 150).code(), StatusCode::kInterrupted);
  ASSERT_TRUE(Run(Short(), "parts", true).ok());
  EXPECT_EQ(Bytes("whole/point_cloud.ply"), Bytes("parts/point_cloud.ply"));
}

TEST_F(ReconstructStageTest, BrokenCheckpointsStartAnew) {
  ASSERT_TRUE(Run(Short(), "whole").ok());
  EXPECT_EQ(Run(Short(), "parts", false, 50).code(), StatusCode::kInterrupted);
  for (const auto& file :
       fs::directory_iterator(workspace_ / "parts" / "checkpoints")) {
    fs::resize_file(file.path(), fs::file_size(file.path()) / 2);
  }
  ASSERT_TRUE(Run(Short(), "parts", true).ok());
  EXPECT_EQ(Bytes("whole/point_cloud.ply"), Bytes("parts/point_cloud.ply"));
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

TEST_F(ReconstructStageTest, TakesACompressedModel) {
  ReconstructStageOptions options;
  options.import = (workspace_ / "trained.spz").string();
  ASSERT_TRUE(splat::WriteSpz(options.import, truth_).ok());
  ASSERT_TRUE(Run(options, "out").ok());
  const nlohmann::json metrics =
      nlohmann::json::parse(Bytes("out/metrics.json"));
  EXPECT_GT(metrics["holdout_psnr"].get<double>(), 35);
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
}

TEST(DisplacementNoteTest, HalfOfThePhotosMayLieAnywhere) {
  EXPECT_EQ(DisplacementNote({}), "");
  EXPECT_EQ(DisplacementNote({{0.2, 800}, {0.5, 800}, {60, 800}}), "");
  EXPECT_EQ(DisplacementNote({{3.9, 800}}), "");
  EXPECT_EQ(DisplacementNote({{1.4, 80}}), "");
  EXPECT_THAT(DisplacementNote({{0.2, 320}, {3, 320}, {5, 320}}),
              testing::HasSubstr("2 of 3 photos"));
  EXPECT_THAT(DisplacementNote({{0.2, 320}, {3, 320}, {5, 320}}),
              testing::HasSubstr("by 3.0 pixels"));
}

TEST_F(ReconstructStageTest, GoingBackIsLoggedAndListed) {
  // A scene that a checkpoint with damaged numbers goes on with.
  EXPECT_EQ(Run(Short(), "out", false, 150).code(), StatusCode::kInterrupted);
  const fs::path folder = workspace_ / "out" / "checkpoints";
  std::optional<splat::TrainingCheckpoint> checkpoint =
      splat::LatestCheckpoint(folder);
  ASSERT_TRUE(checkpoint.has_value());
  for (float& value : checkpoint->model.sh_dc) value = NAN;
  ASSERT_TRUE(splat::SaveCheckpoint(folder, splat::ViewOf(*checkpoint)).ok());
  const Status status = Run(Short(), "out", true);
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_THAT(log_, testing::HasSubstr("training diverged at iteration"));
  const nlohmann::json metrics =
      nlohmann::json::parse(Bytes("out/metrics.json"));
  ASSERT_EQ(metrics["recoveries"].size(), 1u);
  const nlohmann::json& recovery = metrics["recoveries"][0];
  EXPECT_EQ(recovery["back_to"], 133);  // Where the last pruning was.
  EXPECT_EQ(recovery["rate_factor"], 0.5);
  EXPECT_FALSE(recovery["reason"].get<std::string>().empty());
  EXPECT_EQ(metrics["iterations"], 200);
  // progress.csv tells of one course only.
  std::istringstream csv(Bytes("out/progress.csv"));
  std::string line;
  int64_t last = 0;
  while (std::getline(csv, line)) {
    const int64_t row = std::strtoll(line.c_str(), nullptr, 10);
    EXPECT_TRUE(row > last || row == 0) << line;
    last = row;
  }
  EXPECT_EQ(last, 200);
}

TEST_F(ReconstructStageTest, ErrorsNameTheFile) {
  fs::remove(workspace_ / "undistort" / "images" / "photo3.png");
  const Status missing = Run(Short(), "out");
  EXPECT_EQ(missing.code(), StatusCode::kBadInput);
  EXPECT_NE(missing.message().find("photo3.png"), std::string::npos);
}

}  // namespace
}  // namespace freegs::stages
