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
    PipelineOptions options;
    pipeline::OptionTable table = MakeOptionTable(&options);
    ASSERT_TRUE(ApplySettings(workspace(),
                              settings_,
                              table,
                              {{"reconstruct.iterations", "625", "a test"},
                               {"reconstruct.densify_interval",
                                std::to_string(DensifyInterval(625)),
                                "a test"}})
                    .ok());
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
    WriteText(workspace() / "reconstruct" / "metrics.json",
              "{\"holdout_psnr\": 17.6, \"iterations\": " +
                  std::to_string(iterations) + "}");
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

  TemporaryFolder folder_;
  RunRequest request_;
  const std::vector<pipeline::OptionSetting> settings_ = {
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

// Killed after the record was written and before the folder was renamed.
TEST_F(RunExecutionTest, AGoalFindsTheTrainingThatAKilledRunHadFinished) {
  MakeTraining(625);
  fs::rename(workspace() / "reconstruct", workspace() / "reconstruct.partial");
  EXPECT_THAT(RunAtLeast17(), HasSubstr("begins with what there is"));
  EXPECT_TRUE(fs::exists(workspace() / "reconstruct" / "metrics.json"));
}

}  // namespace
}  // namespace freegs::stages
