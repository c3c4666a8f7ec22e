// SPDX-License-Identifier: BSD-3-Clause
// init, status, doctor, and what run and stage refuse before any work.

#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <unistd.h>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/cancellation.h"
#include "core/io/image_io.h"
#include "pipeline/stage_record.h"
#include "pipeline/workspace.h"
#include "stages/commands/doctor_command.h"
#include "stages/commands/init_command.h"
#include "stages/commands/run_command.h"
#include "stages/commands/status_command.h"
#include "stages/plan/plan_command.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class CommandTest : public ::testing::Test {
 protected:
  Status Call(CommandFn command, const std::vector<std::string>& arguments) {
    std::ostringstream out;
    std::ostringstream err;
    CommandContext context{out, err, cancellation_, "freegs_pipeline"};
    const Status status = command(arguments, context);
    out_ = out.str();
    return status;
  }

  void ExpectError(CommandFn command,
                   const std::vector<std::string>& arguments,
                   StatusCode code,
                   const std::string& part) {
    const Status status = Call(command, arguments);
    EXPECT_EQ(status.code(), code) << status.message();
    EXPECT_THAT(status.message(), HasSubstr(part));
  }

  std::string Path(const std::string& name) const {
    return (folder_ / name).string();
  }

  // Three photos that differ.
  void WritePhotos() const {
    fs::create_directories(folder_ / "photos");
    for (const int k : {1, 2, 3}) {
      ASSERT_TRUE(WriteImage(folder_ / "photos" / (std::to_string(k) + ".png"),
                             ImageU8(64, 48, 3, static_cast<uint8_t>(50 * k)))
                      .ok());
    }
  }

  TemporaryFolder folder_;
  CancellationToken cancellation_;
  std::string out_;
};

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
  // The same code as without a result.
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

TEST_F(CommandTest, NoStageIsUpToDateWithAPathThatItNeverRead) {
  WritePhotos();
  const std::vector<std::string> run = {
      Path("photos"), Path("w"), "--to", "ingest"};
  ASSERT_TRUE(Call(RunRunCommand, run).ok());
  fs::create_directory(folder_ / "empty");
  ExpectError(RunRunCommand,
              {Path("empty"), Path("w"), "--to", "ingest"},
              StatusCode::kBadInput,
              "empty: no JPEG, PNG or TIFF photos");
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

TEST_F(CommandTest, RunWithinATimeRefusesWhatDoesNotGoWithIt) {
  WriteText(folder_ / "photos" / "1.jpg", "x");
  const auto refused = [&](std::vector<std::string> more,
                           const std::string& part) {
    more.insert(more.begin(), {Path("photos"), Path("w")});
    ExpectError(RunRunCommand, more, StatusCode::kInvalidArgument, part);
    EXPECT_FALSE(fs::exists(folder_ / "w"));
  };
  refused({"--within", "soon"}, "write 90s, 5m or 1h30m");
  refused({"--within", "5m", "--to", "sfm"}, "without --from and --to");
  refused({"--within", "5m", "--preset", "fast"}, "not with fast");
  refused({"--preset", "auto"}, "--within 5m");
  ExpectError(RunRunCommand,
              {Path("w"), "--within", "5m"},
              StatusCode::kInvalidArgument,
              "run IMAGES WORKSPACE --within 5m");
}

TEST_F(CommandTest, AnAccuracyNeedsPhotosThatAreKeptFromTheTraining) {
  WritePhotos();
  ExpectError(RunRunCommand,
              {Path("photos"),
               Path("w"),
               "--at-least",
               "psnr=27",
               "--ingest.holdout_every",
               "0"},
              StatusCode::kBadInput,
              "ingest.holdout_every");
  EXPECT_FALSE(fs::exists(folder_ / "w" / "sfm.partial"));
  // Nothing was chosen yet that a later run would go on with.
  EXPECT_EQ(pipeline::ReadWorkspaceInfo(folder_ / "w")
                ->settings.count("reconstruct.iterations"),
            0u);
}

TEST_F(CommandTest, RunWithinATimeRemembersWhatItChose) {
  WritePhotos();
  WriteText(folder_ / "w" / "config.ini", "[general]\npreset = auto\n");
  // Without COLMAP it ends in sfm.
  const std::string colmap = Path("no_colmap");
  ExpectError(RunRunCommand,
              {Path("photos"),
               Path("w"),
               "--within",
               "5m",
               "--reconstruct.sh_degree",
               "1",
               "--sfm.colmap",
               colmap},
              StatusCode::kMissingDependency,
              colmap);
  const StatusOr<pipeline::WorkspaceInfo> info =
      pipeline::ReadWorkspaceInfo(folder_ / "w");
  ASSERT_TRUE(info.ok());
  EXPECT_EQ(info->settings.count("reconstruct.iterations"), 1u);
  EXPECT_EQ(info->settings.at("reconstruct.sh_degree"), "1");
  // So it goes on without a time, with the same options, and whatever preset
  // config.ini names.
  ExpectError(
      RunRunCommand, {Path("w")}, StatusCode::kMissingDependency, colmap);
  EXPECT_EQ(pipeline::ReadWorkspaceInfo(folder_ / "w")->settings,
            info->settings);
}

TEST_F(CommandTest, WhatIsChosenBeforeThePhotosAreReadIsNotRemembered) {
  WriteText(folder_ / "photos" / "1.jpg", "x");
  ExpectError(RunRunCommand,
              {Path("photos"),
               Path("w"),
               "--preset",
               "auto",
               "--within",
               "5m",
               "--reconstruct.sh_degree",
               "1"},
              StatusCode::kBadInput,
              "ingest");
  const StatusOr<pipeline::WorkspaceInfo> info =
      pipeline::ReadWorkspaceInfo(folder_ / "w");
  ASSERT_TRUE(info.ok());
  EXPECT_EQ(
      info->settings,
      (std::map<std::string, std::string>{{"reconstruct.sh_degree", "1"}}));
}

TEST_F(CommandTest, RunAtLeastRefusesWhatDoesNotGoWithIt) {
  WriteText(folder_ / "photos" / "1.jpg", "x");
  const auto refused = [&](std::vector<std::string> more,
                           const std::string& part) {
    more.insert(more.begin(), {Path("photos"), Path("w")});
    ExpectError(RunRunCommand, more, StatusCode::kInvalidArgument, part);
  };
  refused({"--at-least", "27"}, "write psnr=27");
  refused({"--at-least", "psnr=27", "--within", "5m"}, "not go together");
  refused({"--at-least", "psnr=27", "--to", "sfm"}, "without --from and --to");
  refused({"--at-least", "psnr=27", "--preset", "fast"}, "not with fast");
  EXPECT_FALSE(fs::exists(folder_ / "w"));
  refused({"--at-least", "psnr=27", "--reconstruct.iterations", "900"},
          "reconstruct.iterations is what --at-least chooses");
}

TEST_F(CommandTest, ARefusedGoalForgetsNothing) {
  WriteText(folder_ / "photos" / "1.jpg", "x");
  ExpectError(RunRunCommand,
              {Path("photos"), Path("w"), "--seed", "4"},
              StatusCode::kBadInput,
              "ingest");
  WriteText(folder_ / "w" / "config.ini", "[reconstruct]\niterations = 900\n");
  const std::string before = ReadText(folder_ / "w" / "workspace.json");
  ExpectError(RunRunCommand,
              {Path("photos"), Path("w"), "--at-least", "psnr=27"},
              StatusCode::kInvalidArgument,
              "reconstruct.iterations is what --at-least chooses");
  EXPECT_EQ(ReadText(folder_ / "w" / "workspace.json"), before);
  WriteText(folder_ / "w" / "config.ini", "[reconstruct]\nno_such = 1\n");
  ExpectError(RunRunCommand,
              {Path("photos"), Path("w"), "--within", "5m"},
              StatusCode::kInvalidArgument,
              "no_such");
  EXPECT_EQ(ReadText(folder_ / "w" / "workspace.json"), before);
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
  if (geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  WriteText(folder_ / "photos" / "1.jpg", "x");
  pipeline::WorkspaceInfo info;
  info.images = Path("photos");
  fs::create_directory(folder_ / "w");
  ASSERT_TRUE(pipeline::WriteWorkspaceInfo(folder_ / "w", info).ok());
  WriteText(folder_ / "w" / ".lock", "");
  fs::permissions(folder_ / "w", fs::perms::owner_read | fs::perms::owner_exec);
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
