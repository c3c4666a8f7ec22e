// SPDX-License-Identifier: BSD-3-Clause
// A small workspace in which stage reconstruct can run.

#ifndef FREEGS_TESTS_STAGES_RECONSTRUCT_RECONSTRUCT_FIXTURE_H_
#define FREEGS_TESTS_STAGES_RECONSTRUCT_RECONSTRUCT_FIXTURE_H_

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "photos/photo_list.h"
#include "sfm/scene/model_io.h"
#include "splat/render/renderer.h"
#include "stages/reconstruct/reconstruct_stage.h"
#include "tests/splat/test_scene.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {

// A workspace as undistort leaves it: ten small photos of a known model, two of
// them held out, and the model's centres as points.
class ReconstructFixture : public testing::Test {
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
      std::filesystem::create_directories(workspace_ / "undistort" / "images");
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
    std::filesystem::create_directories(workspace_ / "ingest");
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
    context.deadline = deadline_;
    context.resuming = resuming;
    context.pool = &pool;
    context.cancellation = &cancellation;
    context.progress = [&](const Progress& progress) {
      if (progress.done >= cancel_at) cancellation.Cancel();
    };
    context.log = [&](pipeline::LogLevel, const std::string& line) {
      log_ += line + "\n";
      if (on_log_) on_log_(line);
      if (!cancel_on_.empty() && line.find(cancel_on_) != std::string::npos) {
        cancellation.Cancel();
      }
    };
    std::filesystem::create_directories(context.output);
    const auto stage = MakeReconstructStage(options, 3);
    for (const std::filesystem::path& input : stage->Inputs(context)) {
      EXPECT_TRUE(std::filesystem::exists(
          input.is_absolute() ? input : workspace_ / input))
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
  const std::filesystem::path workspace_ = temporary_.path();
  std::filesystem::path preview_;
  std::optional<std::chrono::steady_clock::time_point> deadline_;
  std::string log_;        // The log of all runs.
  std::string cancel_on_;  // Text of the log line to cancel at, if any.
  std::function<void(const std::string& line)> on_log_;
  splat::GaussianModel truth_;
};

}  // namespace freegs::stages

#endif  // FREEGS_TESTS_STAGES_RECONSTRUCT_RECONSTRUCT_FIXTURE_H_
