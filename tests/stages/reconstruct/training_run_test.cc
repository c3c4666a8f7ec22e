// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/training_run.h"

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iomanip>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/cancellation.h"
#include "core/io/image_io.h"
#include "photos/photo_list.h"
#include "splat/images/resolution_schedule.h"
#include "splat/train/checkpoint.h"
#include "splat/train/trainer.h"
#include "stages/evaluation/evaluation.h"
#include "stages/reconstruct/reconstruct_options.h"
#include "stages/scene/training_scene.h"
#include "stages/scene/workspace_scene.h"
#include "tests/stages/reconstruct/reconstruct_fixture.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

class TrainingRunTest : public ReconstructFixture {
 protected:
  // The rows of progress.csv without the seconds, the second column.
  std::vector<std::string> Curve(const std::string& folder) const {
    std::istringstream csv(Bytes(folder + "/progress.csv"));
    std::vector<std::string> rows;
    std::string line;
    while (std::getline(csv, line)) {
      const size_t first = line.find(',');
      rows.push_back(line.erase(first, line.find(',', first + 1) - first));
    }
    return rows;
  }

  // Goes on from the checkpoint in `folder` to the milestone at step 100, which
  // is cancelled, and saves that. No run can be stopped there at will.
  void StopInMilestone(const fs::path& folder) const {
    ThreadPool pool(2);
    const StatusOr<TrainingScene> scene = ReadTrainingScene(workspace_);
    ASSERT_TRUE(scene.ok()) << scene.status().message();
    splat::TrainingImagesOptions image_options;
    image_options.num_levels = 4;
    StatusOr<splat::TrainingImages> images =
        LoadPhotos(*scene, scene->photos.train, image_options, pool);
    ASSERT_TRUE(images.ok()) << images.status().message();
    splat::TrainerOptions options =
        MakeTrainerOptions(Short(), 1, int64_t{1} << 33, 3).value();
    options.schedule.resolution_steps =
        splat::SpectrumResolutionSteps(&*images).value();
    splat::Trainer trainer(
        options, InitialModel(*scene).value(), scene->extent, &*images, pool);
    std::optional<splat::TrainingCheckpoint> checkpoint =
        splat::LatestCheckpoint(folder);
    ASSERT_TRUE(checkpoint.has_value());
    ASSERT_EQ(checkpoint->iteration, 50);
    ASSERT_TRUE(trainer.Restore(*std::move(checkpoint)).ok());
    CancellationToken cancelled;
    cancelled.Cancel();
    double loss_sum = 0;  // The sum over the steps since the row of step 50.
    while (trainer.iteration() < 100) {
      const StatusOr<splat::StepReport> report = trainer.Step(&cancelled);
      ASSERT_TRUE(report.ok()) << report.status().message();
      EXPECT_EQ(report->interrupted, trainer.iteration() == 100);
      loss_sum += report->loss;
    }
    splat::TrainingCheckpoint stopped = trainer.Save();
    std::ostringstream text;
    text << std::setprecision(17) << loss_sum;
    stopped.facts["row_loss_sum"] = text.str();
    stopped.facts["row_loss_count"] = "50";
    ASSERT_TRUE(splat::SaveCheckpoint(folder, splat::ViewOf(stopped)).ok());
  }
};

TEST_F(TrainingRunTest, ReportsTheSearchAboutExposure) {
  const Status status = Run(Auto(), "out");
  ASSERT_TRUE(status.ok()) << status.message();
  const nlohmann::json metrics = Metrics("out");
  EXPECT_EQ(metrics["budget"], 500);
  const nlohmann::json& search = metrics["exposure_search"];
  ASSERT_TRUE(search.is_object());
  const bool learn = search["learn"].get<bool>();
  for (const char* trial : {"without", "with"}) {
    EXPECT_GT(search[trial]["trained_psnr"].get<double>(), 10);
    EXPECT_GT(search[trial]["others_psnr"].get<double>(), 10);
  }
  EXPECT_GT(metrics["holdout_psnr_fitted"].get<double>(), 15);
  EXPECT_THAT(
      log_,
      testing::HasSubstr(learn ? "exposure of each photo is learnt"
                               : "exposure of each photo is not learnt"));
  // The model is the one of a training without a search.
  ReconstructStageOptions options = Auto();
  options.exposure = "off";
  ASSERT_TRUE(Run(options, "off").ok());
  EXPECT_TRUE(Metrics("off")["exposure_search"].is_null());
  options.exposure = "on";
  ASSERT_TRUE(Run(options, "on").ok());
  const std::string off = Bytes("off/point_cloud.ply");
  const std::string on = Bytes("on/point_cloud.ply");
  EXPECT_TRUE(on != off);
  EXPECT_TRUE(Bytes("out/point_cloud.ply") == (learn ? on : off));
  // One exposure for each training photo, where it was learnt.
  EXPECT_FALSE(fs::exists(workspace_ / "off" / "exposure.json"));
  EXPECT_EQ(fs::exists(workspace_ / "out" / "exposure.json"), learn);
  const auto photos =
      photos::ReadPhotoList(workspace_ / "ingest" / "images.json");
  ASSERT_TRUE(photos.ok());
  const auto exposures = nlohmann::json::parse(Bytes("on/exposure.json"));
  size_t trained = 0;
  for (const photos::Photo& photo : photos->photos) {
    trained += photo.split == photos::PhotoSplit::kTrain ? 1 : 0;
  }
  EXPECT_EQ(exposures.size(), trained);
}

// Photos become darker one by one, and the scene has the mean of them.
TEST_F(TrainingRunTest, HoldoutPhotosAreMeasuredInTheirNeighboursExposure) {
  const fs::path photos = workspace_ / "undistort" / "images";
  for (int k = 0; k < 10; ++k) {
    const fs::path path = photos / ("photo" + std::to_string(k) + ".png");
    ImageU8 photo = *ReadRgb(path);
    for (size_t i = 0; i < photo.size(); ++i) {
      photo.data()[i] = static_cast<uint8_t>(photo.data()[i] * (1 - 0.07 * k));
    }
    ASSERT_TRUE(WriteImage(path, photo).ok());
  }
  ReconstructStageOptions options = Short();
  options.exposure = "on";
  options.iterations = 600;
  ASSERT_TRUE(Run(options, "reconstruct").ok());
  StatusOr<WorkspaceScene> scene = ReadWorkspaceScene(workspace_);
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  ThreadPool pool(2);
  const auto psnr = [&]() -> double {
    const auto quality =
        MeasureHoldoutQuality(*scene, photos, {}, CancellationToken(), pool);
    return quality.ok() && *quality ? (*quality)->psnr : -1;
  };
  const double with = psnr();
  EXPECT_NEAR(Metrics("reconstruct")["holdout_psnr"].get<double>(), with, 0.01);
  scene->exposures.clear();
  EXPECT_GT(with, psnr() + 1);
}

TEST_F(TrainingRunTest, StoppedWhileOrAfterSearching) {
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

TEST_F(TrainingRunTest, TheSearchShowsProgressAndCanBeStopped) {
  EXPECT_EQ(Run(Auto(), "out", false, 50).code(), StatusCode::kInterrupted);
  EXPECT_THAT(log_, testing::Not(testing::HasSubstr("exposure of each")));
}

TEST_F(TrainingRunTest, TheSearchNeedsNoHoldout) {
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
  EXPECT_TRUE(metrics.at("exposure_search").contains("learn"));
  EXPECT_TRUE(metrics.at("holdout_psnr").is_null());
  EXPECT_TRUE(metrics.at("holdout_psnr_fitted").is_null());
}

TEST_F(TrainingRunTest, ATrainingThatIsLookedAtHasTheSameResult) {
  ASSERT_TRUE(Run(Short(), "alone").ok());
  preview_ = workspace_ / "preview.jpg";
  ASSERT_TRUE(Run(Short(), "seen").ok());
  const StatusOr<ImageU8> picture = ReadRgb(preview_);
  ASSERT_TRUE(picture.ok()) << picture.status().message();
  EXPECT_EQ(picture->width(), 80);
  EXPECT_EQ(ReadText(workspace_ / "seen" / "point_cloud.ply"),
            ReadText(workspace_ / "alone" / "point_cloud.ply"));
}

TEST_F(TrainingRunTest, InterruptedAndResumedGivesTheSameBytes) {
  ASSERT_TRUE(Run(Short(), "whole").ok());
  EXPECT_EQ(Run(Short(), "parts", false, 50).code(), StatusCode::kInterrupted);
  EXPECT_EQ(Run(Short(), "parts", true, 150).code(), StatusCode::kInterrupted);
  ASSERT_TRUE(Run(Short(), "parts", true).ok());
  EXPECT_EQ(Bytes("whole/point_cloud.ply"), Bytes("parts/point_cloud.ply"));
}

// The curve of the training, too, also when the interruption comes between two
// of its rows (pruning is no multiple of 50 steps), or before the measurement
// of a row.
TEST_F(TrainingRunTest, InterruptedAndResumedGivesTheSameCurve) {
  ASSERT_TRUE(Run(Short(), "whole").ok());
  EXPECT_EQ(Curve("whole").size(), 5u);
  for (const std::string step : {"133", "100"}) {
    const std::string folder = "parts" + step;
    cancel_on_ = "at iteration " + step;
    EXPECT_EQ(Run(Short(), folder).code(), StatusCode::kInterrupted);
    // The holdout photos of step 100 were not measured.
    EXPECT_EQ(Curve(folder).size(), step == "100" ? 2u : 3u);
    cancel_on_.clear();
    log_.clear();
    ASSERT_TRUE(Run(Short(), folder, true).ok());
    EXPECT_THAT(log_,
                testing::HasSubstr("resuming at iteration " + step + "\n"));
    EXPECT_EQ(Curve(folder), Curve("whole"));
    EXPECT_EQ(Bytes(folder + "/point_cloud.ply"),
              Bytes("whole/point_cloud.ply"));
  }
}

TEST_F(TrainingRunTest, AMilestoneThatWasStoppedIsMadeUpFor) {
  ASSERT_TRUE(Run(Short(), "whole").ok());
  EXPECT_EQ(Run(Short(), "parts", false, 50).code(), StatusCode::kInterrupted);
  StopInMilestone(workspace_ / "parts" / "checkpoints");
  cancel_on_ = "resuming at iteration 100";
  const Status again = Run(Short(), "parts", true);
  EXPECT_EQ(again.code(), StatusCode::kInterrupted);
  EXPECT_THAT(again.message(),
              testing::HasSubstr("in the milestone at iteration 100"));
  cancel_on_.clear();
  log_.clear();
  ASSERT_TRUE(Run(Short(), "parts", true).ok());
  EXPECT_THAT(log_, testing::HasSubstr("simplification at iteration 100"));
  EXPECT_EQ(Curve("parts"), Curve("whole"));
  EXPECT_EQ(Bytes("parts/point_cloud.ply"), Bytes("whole/point_cloud.ply"));
}

TEST_F(TrainingRunTest, BrokenCheckpointsStartAnew) {
  ASSERT_TRUE(Run(Short(), "whole").ok());
  EXPECT_EQ(Run(Short(), "parts", false, 50).code(), StatusCode::kInterrupted);
  for (const auto& file :
       fs::directory_iterator(workspace_ / "parts" / "checkpoints")) {
    fs::resize_file(file.path(), fs::file_size(file.path()) / 2);
  }
  ASSERT_TRUE(Run(Short(), "parts", true).ok());
  EXPECT_EQ(Bytes("whole/point_cloud.ply"), Bytes("parts/point_cloud.ply"));
}

TEST_F(TrainingRunTest, GoingBackIsLoggedAndListed) {
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

TEST_F(TrainingRunTest, ACheckpointThatDoesNotFitIsNamed) {
  EXPECT_EQ(Run(Short(), "out", false, 50).code(), StatusCode::kInterrupted);
  ReconstructStageOptions shorter = Short();
  shorter.iterations = 20;
  const Status status = Run(shorter, "out", true);
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(),
              testing::HasSubstr("iteration_00000050.ckpt: the checkpoint is "
                                 "of iteration 50, but the training has 20;"));
}

TEST_F(TrainingRunTest, DoesNotSearchWhenTheTimeIsUp) {
  deadline_ = std::chrono::steady_clock::now();
  const Status status = Run(Auto(), "out");
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_THAT(log_, testing::HasSubstr("exposure of each photo is not learnt"));
  EXPECT_THAT(log_, testing::HasSubstr("the time is up"));
  const nlohmann::json metrics = Metrics("out");
  EXPECT_TRUE(metrics["exposure_search"].is_null());
}

// Also after an interruption, from which no step is taken up: exposure cannot
// begin to be learnt in the middle.
TEST_F(TrainingRunTest, ARunWithTimeSearchesAgain) {
  ASSERT_TRUE(Run(Auto(), "whole").ok());
  deadline_ = std::chrono::steady_clock::now();
  const Status status = Run(Auto(), "parts", false, 50);
  EXPECT_EQ(status.code(), StatusCode::kInterrupted);
  EXPECT_THAT(status.message(), testing::HasSubstr("will start afresh"));
  deadline_.reset();
  ASSERT_TRUE(Run(Auto(), "parts", true).ok());
  EXPECT_EQ(Bytes("whole/point_cloud.ply"), Bytes("parts/point_cloud.ply"));
  EXPECT_EQ(Metrics("whole")["exposure_search"],
            Metrics("parts")["exposure_search"]);
}

TEST_F(TrainingRunTest, EndsWhenTheTimeIsUp) {
  ReconstructStageOptions options = Short();
  options.iterations = 500;
  deadline_ = std::chrono::steady_clock::now();
  const Status status = Run(options, "out");
  ASSERT_TRUE(status.ok()) << status.message();
  // The fewest steps that make a scene.
  EXPECT_EQ(Metrics("out")["iterations"], 300);
  EXPECT_THAT(log_, testing::HasSubstr("ends after 300 of 500 iterations"));
  EXPECT_GT(Metrics("out")["holdout_psnr"].get<double>(), 15);

  log_.clear();
  deadline_ = std::chrono::steady_clock::now() + std::chrono::hours(1);
  ASSERT_TRUE(Run(options, "later").ok());
  EXPECT_EQ(Metrics("later")["iterations"], 500);
  EXPECT_THAT(log_, testing::Not(testing::HasSubstr("time is up")));
}

}  // namespace
}  // namespace freegs::stages
