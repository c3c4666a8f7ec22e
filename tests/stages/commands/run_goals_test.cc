// SPDX-License-Identifier: BSD-3-Clause
// What run --within and run --at-least refuse, and what they remember.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/workspace.h"
#include "stages/commands/run_command.h"
#include "tests/stages/commands/command_fixture.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

class RunGoalsTest : public CommandFixture {};

TEST_F(RunGoalsTest, RunWithinATimeRefusesWhatDoesNotGoWithIt) {
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

TEST_F(RunGoalsTest, AnAccuracyNeedsPhotosThatAreKeptFromTheTraining) {
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

TEST_F(RunGoalsTest, AGoalNeedsATraining) {
  WritePhotos();
  WriteText(folder_ / "scene.ply", "x");
  const std::vector<std::pair<std::string, std::string>> goals = {
      {"--at-least", "psnr=27"}, {"--within", "5m"}};
  for (const auto& [option, value] : goals) {
    ExpectError(RunRunCommand,
                {Path("photos"),
                 Path("w"),
                 option,
                 value,
                 "--reconstruct.import",
                 Path("scene.ply")},
                StatusCode::kInvalidArgument,
                option + " trains a scene, and reconstruct.import");
    EXPECT_FALSE(fs::exists(folder_ / "w" / "ingest"));
  }
}

TEST_F(RunGoalsTest, RunWithinATimeRemembersWhatItChose) {
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

TEST_F(RunGoalsTest, WhatIsChosenBeforeThePhotosAreReadIsNotRemembered) {
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

TEST_F(RunGoalsTest, RunAtLeastRefusesWhatDoesNotGoWithIt) {
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

TEST_F(RunGoalsTest, ARefusedGoalForgetsNothing) {
  WriteText(folder_ / "photos" / "1.jpg", "x");
  ExpectError(RunRunCommand,
              {Path("photos"), Path("w"), "--seed", "4"},
              StatusCode::kBadInput,
              "ingest");
  const std::string before = ReadText(folder_ / "w" / "workspace.json");
  // The second is how long the first training would be, but another may follow.
  for (const char* const iterations : {"900", "625"}) {
    WriteText(folder_ / "w" / "config.ini",
              std::string("[reconstruct]\niterations = ") + iterations + "\n");
    ExpectError(RunRunCommand,
                {Path("photos"), Path("w"), "--at-least", "psnr=27"},
                StatusCode::kInvalidArgument,
                "reconstruct.iterations is what --at-least chooses");
    EXPECT_EQ(ReadText(folder_ / "w" / "workspace.json"), before);
  }
  WriteText(folder_ / "w" / "config.ini", "[reconstruct]\nno_such = 1\n");
  ExpectError(RunRunCommand,
              {Path("photos"), Path("w"), "--within", "5m"},
              StatusCode::kInvalidArgument,
              "no_such");
  EXPECT_EQ(ReadText(folder_ / "w" / "workspace.json"), before);
}

}  // namespace
}  // namespace freegs::stages
