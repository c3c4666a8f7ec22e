// SPDX-License-Identifier: BSD-3-Clause
// init, status, doctor, and what run and stage refuse before any work.

#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "pipeline/stage_record.h"
#include "pipeline/workspace.h"
#include "stages/commands/doctor_command.h"
#include "stages/commands/init_command.h"
#include "stages/commands/run_command.h"
#include "stages/commands/status_command.h"
#include "stages/plan/plan_command.h"
#include "tests/stages/commands/command_fixture.h"
#include "tests/unprivileged.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class CommandTest : public CommandFixture {};

TEST_F(CommandTest, TemplateInTheSourcesIsWhatInitWrites) {
  const fs::path folder = fs::path(FREEGS_SOURCE_DIR) / "workspace_template";
  EXPECT_EQ(ReadText(folder / "config.ini"), ConfigTemplate())
      << "after a change of options: delete workspace_template/config.ini and "
         "run `freegs_pipeline init workspace_template`";
  EXPECT_EQ(ReadText(folder / "README.md"), WorkspaceReadme());
}

TEST_F(CommandTest, InitKeepsWhatIsThere) {
  ASSERT_TRUE(Call(RunInitCommand, {Path("w")}).ok());
  EXPECT_EQ(ReadText(folder_ / "w" / "config.ini"), ConfigTemplate());
  EXPECT_TRUE(fs::exists(folder_ / "w" / "README.md"));
  WriteText(folder_ / "w" / "config.ini", "[general]\nseed = 3\n");
  ASSERT_TRUE(Call(RunInitCommand, {Path("w")}).ok());
  EXPECT_EQ(ReadText(folder_ / "w" / "config.ini"), "[general]\nseed = 3\n");
  EXPECT_THAT(out_, HasSubstr("left as it is"));

  WriteText(folder_ / "file", "");
  ExpectError(
      RunInitCommand, {Path("file")}, StatusCode::kBadInput, "not a folder");
  WriteText(folder_ / "photos" / "1.jpg", "x");
  ExpectError(RunInitCommand,
              {Path("photos")},
              StatusCode::kBadInput,
              "is not a workspace");
  ExpectError(
      RunInitCommand, {}, StatusCode::kInvalidArgument, "init WORKSPACE");
}

// A common config.ini on a disk that is not there.
TEST_F(CommandTest, AConfigThatLeadsNowhereIsNotPassedOver) {
  ASSERT_TRUE(Call(RunInitCommand, {Path("w")}).ok());
  const fs::path config = folder_ / "w" / "config.ini";
  fs::remove(config);
  fs::create_symlink(folder_ / "none" / "common.ini", config);
  ExpectError(
      RunStatusCommand, {Path("w")}, StatusCode::kBadInput, "config.ini");
  ASSERT_TRUE(Call(RunInitCommand, {Path("w")}).ok());
  EXPECT_TRUE(fs::is_symlink(config));
}

TEST_F(CommandTest, StatusOfANewWorkspace) {
  ASSERT_TRUE(Call(RunInitCommand, {Path("w")}).ok());
  ASSERT_TRUE(Call(RunStatusCommand, {Path("w")}).ok());
  EXPECT_THAT(out_, HasSubstr("not run yet"));
  ASSERT_TRUE(Call(RunStatusCommand, {Path("w"), "--json"}).ok());
  const nlohmann::json json = nlohmann::json::parse(out_);
  EXPECT_EQ(json["stages"].size(), 6u);
  EXPECT_EQ(json["stages"][0]["stage"], "ingest");
  EXPECT_EQ(json["stages"][0]["status"], "missing");
  EXPECT_EQ(json["running"], false);
}

TEST_F(CommandTest, StatusTellsAnEmptyDefaultFromNone) {
  ASSERT_TRUE(Call(RunInitCommand, {Path("w")}).ok());
  WriteText(folder_ / "w" / "config.ini", "[ingest]\nholdout = none\n");
  ASSERT_TRUE(Call(RunStatusCommand, {Path("w")}).ok());
  EXPECT_THAT(out_, HasSubstr("* ingest.holdout none  (default empty)"));
}

TEST_F(CommandTest, StatusErrors) {
  ExpectError(RunStatusCommand,
              {Path("none")},
              StatusCode::kBadInput,
              "no such workspace");
  ExpectError(RunStatusCommand, {}, StatusCode::kInvalidArgument, "WORKSPACE");
  WriteText(folder_ / "w" / "workspace.json", "{");
  ExpectError(
      RunStatusCommand, {Path("w")}, StatusCode::kBadInput, "workspace.json");
}

TEST_F(CommandTest, RunTakesAFolderThatAPowerCutLeft) {
  WriteText(folder_ / "photos" / "1.jpg", "x");
  WriteText(folder_ / "w" / "workspace.json.part", "{");
  WriteText(folder_ / "w" / "log.txt", "");
  ExpectError(RunRunCommand,
              {Path("photos"), Path("w")},
              StatusCode::kBadInput,
              "ingest");
}

TEST_F(CommandTest, PhotosMayLieInTheWorkspaceBeforeThereIsOne) {
  for (const char* workspace : {"w", "v"}) {
    WriteText(folder_ / workspace / "photos" / "day" / "1.jpg", "x");
  }
  ExpectError(RunRunCommand,
              {Path("w/photos/day"), Path("w")},
              StatusCode::kBadInput,
              "ingest");
  EXPECT_TRUE(fs::exists(folder_ / "w" / "workspace.json"));
  // Those of another folder.
  ExpectError(RunRunCommand,
              {Path("w/photos"), Path("v")},
              StatusCode::kBadInput,
              "is not a workspace");
  ASSERT_TRUE(Call(RunInitCommand, {Path("v")}).ok());
  EXPECT_TRUE(fs::exists(folder_ / "v" / "config.ini"));
  WriteText(folder_ / "u" / "photos" / "1.jpg", "x");
  WriteText(folder_ / "u" / "2.jpg", "x");
  ExpectError(
      RunInitCommand, {Path("u")}, StatusCode::kBadInput, "is not a workspace");
  ExpectError(RunRunCommand,
              {Path("u/photos"), Path("u")},
              StatusCode::kBadInput,
              "is not a workspace");
}

TEST_F(CommandTest, AFolderWithMoreThanThePhotosIsNoWorkspace) {
  WriteText(folder_ / "w" / "2024" / "trip" / "1.jpg", "x");
  WriteText(folder_ / "w" / "2024" / "other" / "1.jpg", "x");
  WriteText(folder_ / "w" / "2024" / ".thumbnails" / "1.png", "x");
  const auto refuse = [this](const std::string& photos,
                             const std::string& part) {
    ExpectError(
        RunRunCommand, {Path(photos), Path("w")}, StatusCode::kBadInput, part);
  };
  refuse("w/2024/trip", "is not a workspace");
  EXPECT_FALSE(fs::exists(folder_ / "w" / "workspace.json"));
  fs::remove_all(folder_ / "w" / "2024" / "other");
  WriteText(folder_ / "w" / "2024" / "notes.txt", "x");
  refuse("w/2024/trip", "is not a workspace");
  fs::remove(folder_ / "w" / "2024" / "notes.txt");
  // A link to the photos, or above them, and none to a folder of others.
  fs::rename(folder_ / "w" / "2024", folder_ / "2024");
  fs::create_directory_symlink(folder_ / "2024", folder_ / "w" / "link");
  WriteText(folder_ / "2024" / "other" / "1.jpg", "x");
  refuse("w/link/trip", "is not a workspace");
  fs::remove_all(folder_ / "2024" / "other");
  WriteText(folder_ / "w" / "Thumbs.db", "x");
  WriteText(folder_ / "2024" / "Thumbs.db", "x");
  refuse("w/link/trip", "ingest");
  EXPECT_TRUE(fs::exists(folder_ / "w" / "workspace.json"));
}

TEST_F(CommandTest, AMistypedPathIsNotTakenForOneThatIsGone) {
  WriteText(folder_ / "photos" / "1.jpg", "x");
  fs::create_directories(folder_ / "w" / "sfm");
  ASSERT_TRUE(
      pipeline::WriteStageRecord(folder_ / "w" / "sfm", pipeline::StageRecord())
          .ok());
  const std::string path = Path("none");
  ExpectError(RunRunCommand,
              {Path("photos"), Path("w"), "--sfm.import", path},
              StatusCode::kBadInput,
              "--sfm.import: " + path);
  EXPECT_FALSE(fs::exists(folder_ / "w" / "workspace.json"));
  // The exit code is the same as without a result.
  fs::create_directories(folder_ / "w" / "bootstrap");
  ASSERT_TRUE(pipeline::WriteStageRecord(folder_ / "w" / "bootstrap",
                                         pipeline::StageRecord())
                  .ok());
  ExpectError(RunRunCommand,
              {Path("photos"), Path("w"), "--bootstrap.model", path},
              StatusCode::kMissingDependency,
              "--bootstrap.model: " + path);
  // The last one counts.
  ExpectError(RunRunCommand,
              {Path("photos"),
               Path("w"),
               "--sfm.import",
               path,
               "--sfm.import",
               Path("photos")},
              StatusCode::kBadInput,
              "ingest");
  fs::remove(folder_ / "w" / "workspace.json");
  // A path that the workspace remembers may be gone.
  pipeline::WorkspaceInfo info;
  info.images = Path("photos");
  info.settings["sfm.import"] = pipeline::DisplayPath(folder_ / "w", path);
  ASSERT_TRUE(pipeline::WriteWorkspaceInfo(folder_ / "w", info).ok());
  ExpectError(RunRunCommand,
              {Path("photos"), Path("w"), "--sfm.import", path},
              StatusCode::kBadInput,
              "ingest");
}

// The runner would say that the interrupted run waits for model.json.
TEST_F(CommandTest, AMistypedPathIsToldToAnInterruptedRunToo) {
  WriteText(folder_ / "photos" / "1.jpg", "x");
  for (const char* file :
       {"sfm.partial/partial.json", "bootstrap.partial/partial.json"}) {
    WriteText(folder_ / "w" / file, "{}");
  }
  pipeline::WorkspaceInfo info;
  info.images = Path("photos");
  ASSERT_TRUE(pipeline::WriteWorkspaceInfo(folder_ / "w", info).ok());
  const std::string path = Path("none");
  ExpectError(RunRunCommand,
              {Path("photos"), Path("w"), "--bootstrap.model", path},
              StatusCode::kMissingDependency,
              "--bootstrap.model: " + path);
  ExpectError(RunStageCommand,
              {"sfm", Path("w"), "--sfm.import", path},
              StatusCode::kBadInput,
              "--sfm.import: " + path);
  EXPECT_TRUE(pipeline::ReadWorkspaceInfo(folder_ / "w")->settings.empty());
}

TEST_F(CommandTest, NoStageIsUpToDateWithAPathThatItNeverRead) {
  WritePhotos();
  const std::vector<std::string> run = {
      Path("photos"), Path("w"), "--to", "ingest"};
  ASSERT_TRUE(Call(RunRunCommand, run).ok());
  const auto status_of_ingest = [&]() -> std::string {
    EXPECT_TRUE(Call(RunStatusCommand, {Path("w"), "--json"}).ok());
    return nlohmann::json::parse(out_)["stages"][0]["status"];
  };
  EXPECT_EQ(status_of_ingest(), "done");
  WriteText(folder_ / "w" / "config.ini",
            "[ingest]\nholdout_list = lits.txt\n");
  EXPECT_EQ(status_of_ingest(), "stale");
  const auto plan = [](const std::vector<std::string>& arguments,
                       CommandContext& context) {
    return RunPlan(arguments, context.out, context.cancellation);
  };
  ASSERT_TRUE(Call(plan, {Path("w"), "--json"}).ok());
  EXPECT_EQ(nlohmann::json::parse(out_)["stages"][0]["state"], "needed");
  ExpectError(RunRunCommand, run, StatusCode::kBadInput, "ingest.holdout_list");

  fs::remove(folder_ / "w" / "config.ini");
  fs::create_directory(folder_ / "empty");
  ExpectError(RunRunCommand,
              {Path("empty"), Path("w"), "--to", "ingest"},
              StatusCode::kBadInput,
              "empty: no JPEG, PNG or TIFF photos");
  ASSERT_TRUE(Call(RunRunCommand, run).ok());
  fs::remove_all(folder_ / "photos");
  EXPECT_TRUE(Call(RunRunCommand, run).ok());
  EXPECT_EQ(status_of_ingest(), "done");
}

TEST_F(CommandTest, ARefusedOrderOfStagesForgetsNothing) {
  WriteText(folder_ / "photos" / "1.jpg", "x");
  fs::create_directories(folder_ / "w");
  pipeline::WorkspaceInfo info;
  info.images = Path("photos");
  info.settings["general.preset"] = "fast";
  ASSERT_TRUE(pipeline::WriteWorkspaceInfo(folder_ / "w", info).ok());
  ExpectError(RunRunCommand,
              {Path("w"), "--forget", "all", "--from", "export", "--to", "sfm"},
              StatusCode::kInvalidArgument,
              "stage export comes after sfm");
  const auto kept = pipeline::ReadWorkspaceInfo(folder_ / "w");
  ASSERT_TRUE(kept.ok()) << kept.status().message();
  EXPECT_EQ(kept->settings, info.settings);
}

TEST_F(CommandTest, WordsWithOneDashAreNoWorkspace) {
  WriteText(folder_ / "photos" / "1.jpg", "x");
  for (const char* word : {"-preset=fast", "-j4"}) {
    ExpectError(RunRunCommand,
                {Path("photos"), word},
                StatusCode::kInvalidArgument,
                "options begin with two dashes");
  }
}

TEST_F(CommandTest, ValuesThatNoStageTakesAreRefusedBeforeAnyRuns) {
  WriteText(folder_ / "photos" / "1.jpg", "x");
  ExpectError(RunRunCommand,
              {Path("photos"), Path("w"), "--reconstruct.budget", "50k"},
              StatusCode::kInvalidArgument,
              "'50k' is not allowed; allowed: auto, auto:N or 0 .. 1000000000");
  ExpectError(RunRunCommand,
              {Path("photos"), Path("w"), "--sfm.max_image_size", "10"},
              StatusCode::kInvalidArgument,
              "allowed: 0 or 64 .. 100000");
  EXPECT_FALSE(fs::exists(folder_ / "w"));
}

TEST_F(CommandTest, RunRefusesWrongFolders) {
  WriteText(folder_ / "photos" / "1.jpg", "x");
  ExpectError(RunRunCommand, {}, StatusCode::kInvalidArgument, "IMAGES");
  ExpectError(RunRunCommand,
              {Path("none"), Path("w")},
              StatusCode::kBadInput,
              "no such folder of photos");
  EXPECT_FALSE(fs::exists(folder_ / "w"));
  ExpectError(RunRunCommand,
              {Path("photos/1.jpg"), Path("w")},
              StatusCode::kBadInput,
              "not a folder");
  ExpectError(RunRunCommand,
              {Path("photos"), Path("photos/w")},
              StatusCode::kInvalidArgument,
              "inside the photo folder");
  WriteText(folder_ / "other" / "undistort" / "images" / "1.jpg", "x");
  ExpectError(RunRunCommand,
              {Path("other/undistort/images"), Path("other")},
              StatusCode::kInvalidArgument,
              "lies in the folder of stage undistort");
  // IMAGES and WORKSPACE swapped.
  ExpectError(RunRunCommand,
              {Path("w"), Path("photos")},
              StatusCode::kBadInput,
              "not a workspace");
  ExpectError(RunRunCommand,
              {Path("photos"), Path("photos/1.jpg")},
              StatusCode::kBadInput,
              "not a folder");
  ExpectError(RunRunCommand,
              {Path("new")},
              StatusCode::kInvalidArgument,
              "does not know its photos");
  ExpectError(RunRunCommand,
              {Path("photos"), Path("w"), "--from", "sfn"},
              StatusCode::kInvalidArgument,
              "ingest, sfm");
  ExpectError(RunRunCommand,
              {Path("photos"), Path("w"), "--sfm.no_such_option", "1"},
              StatusCode::kInvalidArgument,
              "unknown option");
}

TEST_F(CommandTest, PhotosAreNoWorkspace) {
  WriteText(folder_ / "photos" / "1.jpg", "x");
  ExpectError(RunStatusCommand,
              {Path("photos")},
              StatusCode::kBadInput,
              "is not a workspace");
  ExpectError(RunStageCommand,
              {"ingest", Path("photos")},
              StatusCode::kBadInput,
              "is not a workspace");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "photos"), {}), 1);
}

TEST_F(CommandTest, OneRunAtATime) {
  WriteText(folder_ / "photos" / "1.jpg", "x");
  fs::create_directory(folder_ / "w");
  const auto lock = pipeline::WorkspaceLock::Acquire(folder_ / "w");
  ASSERT_TRUE(lock.ok());
  // The other run may be writing what the workspace remembers, so that is not
  // read either.
  WriteText(folder_ / "w" / "workspace.json", "{");
  for (const CommandFn command : {RunRunCommand, RunStageCommand}) {
    const std::string first = command == RunRunCommand ? Path("photos") : "sfm";
    ExpectError(command,
                {first, Path("w")},
                StatusCode::kBadInput,
                "another freegs_pipeline");
  }
}

TEST_F(CommandTest, AWorkspaceThatCannotBeWrittenToIsBadInput) {
  WriteText(folder_ / "photos" / "1.jpg", "x");
  pipeline::WorkspaceInfo info;
  info.images = Path("photos");
  fs::create_directory(folder_ / "w");
  ASSERT_TRUE(pipeline::WriteWorkspaceInfo(folder_ / "w", info).ok());
  WriteText(folder_ / "w" / ".lock", "");
  fs::permissions(folder_ / "w", fs::perms::owner_read | fs::perms::owner_exec);
  const Unprivileged user({fs::path(Path("")), folder_ / "w"});
  if (!user.works()) GTEST_SKIP() << "no other user may look in here";
  ExpectError(RunStageCommand,
              {"ingest", Path("w")},
              StatusCode::kBadInput,
              "cannot write here");
  ExpectError(
      RunRunCommand, {Path("w")}, StatusCode::kBadInput, "cannot write here");
  fs::permissions(folder_ / "w", fs::perms::owner_all);
}

TEST_F(CommandTest, StageErrors) {
  ExpectError(RunStageCommand, {"sfm"}, StatusCode::kInvalidArgument, "STAGE");
  ExpectError(RunStageCommand,
              {"sfm", Path("none")},
              StatusCode::kBadInput,
              "no such workspace");
  fs::create_directory(folder_ / "w");
  ExpectError(RunStageCommand,
              {"sfn", Path("w")},
              StatusCode::kInvalidArgument,
              "ingest, sfm");
  ExpectError(RunStageCommand,
              {"sfm", Path("w")},
              StatusCode::kBadInput,
              "stage ingest has no result");
}

TEST_F(CommandTest, CancelledRunStopsAtOnce) {
  WriteText(folder_ / "photos" / "1.jpg", "x");
  cancellation_.Cancel();
  ExpectError(RunRunCommand,
              {Path("photos"), Path("w")},
              StatusCode::kInterrupted,
              "interrupted");
}

TEST_F(CommandTest, DoctorNamesWhatIsMissing) {
  ExpectError(RunDoctorCommand,
              {"--sfm.colmap", Path("no_colmap")},
              StatusCode::kMissingDependency,
              "apt install colmap");
  EXPECT_THAT(out_, HasSubstr("cores"));
  EXPECT_THAT(out_, HasSubstr("MISSING"));
  ExpectError(
      RunDoctorCommand, {"x"}, StatusCode::kInvalidArgument, "no argument");
}

}  // namespace
}  // namespace freegs::stages
