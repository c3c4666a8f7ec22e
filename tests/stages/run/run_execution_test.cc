// SPDX-License-Identifier: BSD-3-Clause
// What a run with a goal makes of the training that it finds. The results in
// these workspaces have records and hardly any content, so a run ends with an
// error in the first stage that it has to do.

#include "stages/run/run_execution.h"

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "photos/photo_list.h"
#include "pipeline/fingerprint.h"
#include "pipeline/stage.h"
#include "pipeline/stage_record.h"
#include "pipeline/stage_state.h"
#include "stages/registry/presets.h"
#include "stages/registry/stage_registry.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

class RunExecutionTest : public ::testing::Test {
 protected:
  RunExecutionTest() {
    folder_.Write("photos/1.jpg", "photo");
    request_.workspace = workspace();
    request_.info.images = folder_ / "photos";
    request_.to = StageNames().back();
  }

  fs::path workspace() const { return folder_ / "w"; }

  // Makes results of the stages up to a training of 625 iterations with 17.6
  // dB, which ended after so many.
  void MakeTraining(int iterations) {
    MakeTraining({{"reconstruct.iterations", "625", "a test"},
                  {"reconstruct.densify_interval",
                   std::to_string(DensifyInterval(625)),
                   "a test"}},
                 "{\"holdout_psnr\": 17.6, \"iterations\": " +
                     std::to_string(iterations) + "}");
  }

  // Makes results of the stages up to a training with the options that were
  // chosen for it and with this metrics.json.
  void MakeTraining(const std::vector<pipeline::OptionSetting>& chosen,
                    const std::string& metrics) {
    PipelineOptions options;
    pipeline::OptionTable table = MakeOptionTable(&options);
    ASSERT_TRUE(ApplySettings(workspace(), settings_, table, chosen).ok());
    fs::create_directories(workspace() / "ingest");
    photos::PhotoList list;
    photos::Photo photo;
    photo.file = photo.name = "1.jpg";
    photo.width = 64;
    photo.height = 48;
    photo.camera_group = 0;
    photo.split = photos::PhotoSplit::kHoldout;
    list.photos.push_back(photo);
    ASSERT_TRUE(
        photos::WritePhotoList(workspace() / "ingest" / "images.json", list)
            .ok());
    WriteText(workspace() / "reconstruct" / "metrics.json", metrics);
    pipeline::FingerprintCache cache(workspace(), folder_ / "cache");
    pipeline::StageContext context;
    context.workspace = workspace();
    context.images = request_.info.images;
    for (const pipeline::RunnerStage& stage : MakeStages(options, table)) {
      if (stage.stage->name() == "bootstrap") break;
      const fs::path folder = workspace() / stage.stage->name();
      fs::create_directories(folder);
      pipeline::StageRecord record;
      record.fingerprint =
          pipeline::GatherInputs(stage, context, cache).fingerprint;
      ASSERT_TRUE(pipeline::WriteStageRecord(folder, record).ok());
    }
  }

  // Returns what the run logged.
  std::string RunAtLeast17() {
    std::ostringstream log;
    EXPECT_FALSE(
        ExecuteAtLeast(17, settings_, request_, log, CancellationToken()).ok());
    return log.str();
  }

  // Returns what a run within a time logged of a training of 300 iterations,
  // all of which were done, whose metrics.json says this of the search about
  // exposure.
  std::string RunWithinAfter(const std::string& search,
                             const std::string& exposure = "auto") {
    const std::vector<pipeline::OptionSetting> options = {
        {"sfm.max_features", "1200", "a test"},
        {"reconstruct.exposure", exposure, "a test"},
        {"reconstruct.iterations", "300", "a test"},
        {"reconstruct.max_image_size", "640", "a test"},
        {"reconstruct.sh_degree", "2", "a test"},
        {"reconstruct.budget", "auto:50000", "a test"},
        {"reconstruct.densify_interval", "10", "a test"}};
    MakeTraining(options,
                 "{\"iterations\": 300, \"exposure_search\": " + search + "}");
    // Given by the user, so that the run chooses no others.
    settings_.insert(settings_.end(), options.begin(), options.end());
    std::ostringstream log;
    EXPECT_FALSE(
        ExecuteWithin(60, settings_, request_, log, CancellationToken()).ok());
    return log.str();
  }

  TemporaryFolder folder_;
  RunRequest request_;
  std::vector<pipeline::OptionSetting> settings_ = {
      {"general.preset", kAutoPreset, "a test"}};
};

TEST_F(RunExecutionTest, AGoalIsMeasuredByAWholeTraining) {
  MakeTraining(625);
  const std::string log = RunAtLeast17();
  EXPECT_THAT(log, HasSubstr("begins with what there is, a training of 625"));
  EXPECT_THAT(log, HasSubstr("reconstruct: up to date\n"));
}

TEST_F(RunExecutionTest, ATrainingThatEndedEarlyIsDoneAnewForAGoal) {
  MakeTraining(300);
  const std::string log = RunAtLeast17();
  EXPECT_THAT(log, HasSubstr("begins with a training of 625 iterations"));
  EXPECT_THAT(log, HasSubstr("undistort: up to date\n"));
  EXPECT_THAT(log,
              HasSubstr("reconstruct: the training ended after 300 of 625 "
                        "iterations\n"));
  EXPECT_THAT(log, Not(HasSubstr("bootstrap:")));
}

TEST_F(RunExecutionTest,
       ATrainingWithoutTimeForTheSearchIsDoneAnewWithinATime) {
  const std::string log = RunWithinAfter("null");
  EXPECT_THAT(log, HasSubstr("undistort: up to date\n"));
  EXPECT_THAT(log,
              HasSubstr("reconstruct: the training had no time to decide "
                        "whether to learn the exposure of each photo\n"));
  EXPECT_THAT(log, Not(HasSubstr("bootstrap:")));
}

// Also one that had too few photos, or came to nothing.
TEST_F(RunExecutionTest, ATrainingWhoseSearchCameToAnEndIsWhole) {
  EXPECT_THAT(
      RunWithinAfter("{\"learn\": false, \"with\": null, \"without\": null}"),
      HasSubstr("reconstruct: up to date\n"));
}

TEST_F(RunExecutionTest, ATrainingThatNeedsNoSearchIsWhole) {
  EXPECT_THAT(RunWithinAfter("null", "off"),
              HasSubstr("reconstruct: up to date\n"));
}

// Killed after the record was written and before the folder was renamed.
TEST_F(RunExecutionTest, AGoalFindsTheTrainingThatAKilledRunHadFinished) {
  MakeTraining(625);
  fs::rename(workspace() / "reconstruct", workspace() / "reconstruct.partial");
  EXPECT_THAT(RunAtLeast17(), HasSubstr("begins with what there is"));
  EXPECT_TRUE(fs::exists(workspace() / "reconstruct" / "metrics.json"));
}

}  // namespace
}  // namespace freegs::stages
