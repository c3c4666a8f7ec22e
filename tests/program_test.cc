// SPDX-License-Identifier: BSD-3-Clause
// The program as a user calls it: exit codes, and one small scene from photos
// to report.

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/parallel.h"
#include "sfm/colmap/child_process.h"
#include "sfm/scene/model_io.h"
#include "tests/scene_maker/scene.h"
#include "tests/scene_maker/scene_files.h"
#include "tests/temporary_folder.h"

namespace freegs {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

struct Outcome {
  int code = -1;
  std::string text;  // Standard output and error.
};

Outcome CallProgram(std::vector<std::string> argv) {
  sfm::ChildCommand command;
  command.argv = std::move(argv);
  Outcome outcome;
  const StatusOr<sfm::ChildResult> result = sfm::RunChild(
      command,
      [&](std::string_view line) { outcome.text += std::string(line) + "\n"; },
      nullptr);
  if (result.ok()) outcome.code = result->exit_code;
  return outcome;
}

Outcome Call(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), FREEGS_PROGRAM);
  return CallProgram(std::move(arguments));
}

// Runs a command line of the shell in which $0 is the program.
Outcome Shell(const std::string& line) {
  return CallProgram({"/bin/sh", "-c", line, FREEGS_PROGRAM});
}

// A scene of 12 small photos in `folder`.
Status MakeScene(const fs::path& folder, int width, int height) {
  scene_maker::SceneMakerOptions options;
  options.views = 12;
  options.test_views = 2;
  options.width = width;
  options.height = height;
  FREEGS_ASSIGN_OR_RETURN(const scene_maker::Scene scene,
                          scene_maker::BuildScene(options));
  ThreadPool pool;
  return scene_maker::WriteScene(scene, folder, pool, {});
}

TEST(ProgramTest, HelpAndVersion) {
  EXPECT_EQ(Call({"--help"}).code, 0);
  for (const char* command : {"run", "query", "completion"}) {
    EXPECT_THAT(Call({"--help"}).text,
                HasSubstr(std::string("\n  freegs_pipeline ") + command));
  }
  const Outcome version = Call({"--version"});
  EXPECT_EQ(version.code, 0);
  EXPECT_THAT(version.text,
              testing::MatchesRegex(
                  "freegs_pipeline [0-9.]+\ncommit (unknown|[0-9a-f]+(-dirty)?)"
                  "\ninstruction sets .*\nlicence BSD-3-Clause\n"));
  EXPECT_EQ(Call({}).code, 2);
}

TEST(ProgramTest, EveryCommandHasItsHelp) {
  const std::pair<const char*, const char*> commands[] = {
      {"run", "--from"},
      {"run", "--reconstruct.iterations"},
      {"stage", "--reconstruct.iterations"},
      {"init", "init WORKSPACE"},
      {"status", "--json"},
      {"doctor", "--sfm.colmap"},
      {"render", "--no-align"},
      {"query", "--max-hits"},
      {"eval", "--text-threshold"},
      {"features", "--dense-size"},
      {"export", "--without"},
      {"model", "--merges"},
      {"completion", "zsh"},
      {"manual", "options"}};
  for (const auto& [command, option] : commands) {
    const Outcome outcome = Call({command, "--help"});
    EXPECT_EQ(outcome.code, 0) << command;
    EXPECT_THAT(outcome.text,
                testing::StartsWith(std::string("freegs_pipeline ") + command));
    EXPECT_THAT(outcome.text, HasSubstr(option));
  }
  EXPECT_EQ(Call({"help", "query"}).text, Call({"query", "--help"}).text);
  EXPECT_EQ(Call({"help", "rnu"}).code, 2);
}

TEST(ProgramTest, LostOutputIsAnError) {
  for (const char* arguments : {"--version", "--help", "run --help"}) {
    const Outcome outcome =
        Shell("\"$0\" " + std::string(arguments) + " >/dev/full");
    EXPECT_EQ(outcome.code, 1) << arguments;
    EXPECT_THAT(outcome.text, HasSubstr("standard output"));
  }
  const TemporaryFolder folder;
  EXPECT_EQ(
      Shell("\"$0\" init '" + folder.path().string() + "' >/dev/full").code, 1);
}

// The lowest free number would go to a file that the program writes.
TEST(ProgramTest, ClosedStreamsDoNotBecomeFiles) {
  const TemporaryFolder folder;
  ASSERT_TRUE(MakeScene(folder / "scene", 80, 60).ok());
  const std::string in = "cd '" + folder.path().string() + "' && ";
  const Outcome outcome =
      Shell(in + "\"$0\" run scene/images w --to ingest <&- >&- 2>&-");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_TRUE(fs::exists(folder / "w/ingest/stage.json"));
  EXPECT_EQ(fs::file_size(folder / "w/.lock"), 0u);
  EXPECT_EQ(Shell(in + "\"$0\" run scene/images v --to ingest 2>&-").code, 0);
  EXPECT_EQ(fs::file_size(folder / "v/.lock"), 0u);
  EXPECT_EQ(Shell("\"$0\" --version >&-").code, 1);
}

// A group may share a workspace.
TEST(ProgramTest, FilesHaveTheModeThatTheUserWants) {
  const TemporaryFolder folder;
  ASSERT_TRUE(MakeScene(folder / "scene", 80, 60).ok());
  const std::string in = "cd '" + folder.path().string() + "' && ";
  for (const auto& [mask, mode] : {std::pair("002", "664"), {"077", "600"}}) {
    ASSERT_EQ(Shell(in + "umask " + mask +
                    "; \"$0\" run scene/images w --to ingest && stat -c %a "
                    "w/.lock w/workspace.json w/ingest/stage.json >modes")
                  .code,
              0);
    EXPECT_EQ(ReadText(folder / "modes"),
              std::string(mode) + "\n" + mode + "\n" + mode + "\n");
    fs::remove_all(folder / "w");
  }
}

TEST(ProgramTest, OutputsThatCannotBeWritten) {
  const TemporaryFolder folder;
  folder.Write("file", "");
  folder.Write("photos/a.jpg", "not a photo");
  const std::string photos = (folder / "photos").string();
  const std::string below = (folder / "file/w").string();
  EXPECT_EQ(Call({"run", photos, below}).code, 3);
  EXPECT_EQ(Call({"run", photos, ""}).code, 2);
  EXPECT_EQ(Call({"run", "", (folder / "w").string()}).code, 2);
  EXPECT_EQ(Call({"status", ""}).code, 2);
  EXPECT_EQ(Call({"init", ""}).code, 2);
  EXPECT_EQ(Call({"init", below}).code, 3);
  EXPECT_EQ(Call({"export", photos, "--out", below + ".ply"}).code, 3);
}

TEST(ProgramTest, ExitCodes) {
  const TemporaryFolder folder;
  const std::string workspace = (folder / "w").string();
  EXPECT_EQ(Call({"rnu"}).code, 2);
  EXPECT_THAT(Call({"rnu"}).text, HasSubstr("did you mean run?"));
  EXPECT_EQ(Call({"run"}).code, 2);
  EXPECT_EQ(Call({"run", workspace + "_photos", workspace}).code, 3);
  EXPECT_EQ(Call({"status", workspace}).code, 3);
  EXPECT_EQ(Call({"doctor", "--sfm.colmap", workspace}).code, 5);
  EXPECT_EQ(Call({"model"}).code, 2);
  EXPECT_EQ(Call({"model", "ViT-B-16.pt", "--out", workspace}).code, 5);
  // Fewer than three usable photos.
  WriteText(folder / "photos" / "a.jpg", "not a photo");
  const Outcome outcome =
      Call({"run", (folder / "photos").string(), workspace});
  EXPECT_EQ(outcome.code, 3) << outcome.text;
  EXPECT_THAT(outcome.text, HasSubstr("ingest"));
}

// A model that somebody else put into the workspace names a photo outside of
// it.
TEST(ProgramTest, NothingOutsideOfTheWorkspaceIsWritten) {
  const TemporaryFolder folder;
  ASSERT_TRUE(MakeScene(folder / "scene", 80, 60).ok());
  const fs::path workspace = folder / "a" / "w";
  const std::vector<std::string> run = {
      "run",
      (folder / "scene" / "images").string(),
      workspace.string(),
      "--sfm.import",
      (folder / "scene" / "gt" / "transforms.json").string(),
      "--sfm.random_points",
      "10000"};
  std::vector<std::string> sfm = run;
  sfm.insert(sfm.end(), {"--to", "sfm"});
  Outcome outcome = Call(sfm);
  ASSERT_EQ(outcome.code, 0) << outcome.text;

  const fs::path sparse = workspace / "sfm" / "sparse" / "0";
  const auto model = sfm::ReadModel(sparse);
  ASSERT_TRUE(model.ok());
  const fs::path victim = folder / "victim.jpg";
  const fs::path photo = folder / "scene" / "images" / model->images[0].name;
  fs::copy_file(photo, victim);
  std::vector<std::string> undistort = run;
  undistort.insert(undistort.end(),
                   {"--from",
                    "undistort",
                    "--to",
                    "undistort",
                    "--undistort.max_image_size",
                    "32"});
  for (const sfm::ModelFormat format :
       {sfm::ModelFormat::kBinary, sfm::ModelFormat::kText}) {
    fs::remove_all(sparse);
    for (const std::string& name :
         {std::string("../../../../victim.jpg"), victim.string()}) {
      sfm::Reconstruction foreign = *model;
      foreign.images[0].name = name;
      ASSERT_TRUE(sfm::WriteModel(sparse, foreign, format).ok());
      outcome = Call(undistort);
      EXPECT_EQ(outcome.code, 3) << outcome.text;
      EXPECT_THAT(outcome.text, HasSubstr(name));
      EXPECT_TRUE(ReadText(victim) == ReadText(photo));
    }
  }
}

TEST(ProgramTest, FromPhotosToReport) {
  if (Call({"doctor"}).code != 0) GTEST_SKIP() << "COLMAP is not installed";
  const TemporaryFolder folder;
  ASSERT_TRUE(MakeScene(folder / "scene", 240, 180).ok());
  const std::string photos = (folder / "scene" / "images").string();
  const std::string workspace = (folder / "w").string();
  const std::vector<std::string> run = {
      "run", photos, workspace, "--reconstruct.iterations", "300"};

  Outcome outcome = Call(run);
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  for (const char* file : {"ingest/images.json",
                           "sfm/health.json",
                           "undistort/sparse",
                           "reconstruct/point_cloud.ply",
                           "reconstruct/metrics.json",
                           "bootstrap/instances.json",
                           "bootstrap/instance_features.json",
                           "export/report/index.html"}) {
    EXPECT_TRUE(fs::exists(folder / "w" / file)) << file;
  }
  const auto health = nlohmann::json::parse(
      ReadText(folder / "w" / "sfm" / "health.json"), nullptr, false);
  EXPECT_EQ(health["registered"], 12);

  // Words are answered by the model that comes with the program.
  outcome = Call({"query", workspace, "--text", "red ball", "--json"});
  EXPECT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_THAT(outcome.text, HasSubstr("\"hits\""));

  // Again: nothing to do.
  outcome = Call(run);
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(
      outcome.text,
      testing::StartsWith("ingest: up to date\nsfm: up to date\n"
                          "undistort: up to date\nreconstruct: up to date\n"
                          "bootstrap: up to date\nexport: up to date\n"
                          "Open the page of the scene:\n  file:///"));
  EXPECT_THAT(outcome.text, HasSubstr("query " + workspace + " --click "));

  // Moved, without its photos.
  fs::rename(folder / "w", folder / "moved");
  fs::remove_all(folder / "scene" / "images");
  outcome = Call({"run",
                  photos,
                  (folder / "moved").string(),
                  "--reconstruct.iterations",
                  "300"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.text, HasSubstr("input photos is gone"));
  EXPECT_THAT(outcome.text, HasSubstr("export: up to date"));

  // Another folder that is not there was mistyped.
  for (const std::vector<std::string>& mistyped :
       {std::vector<std::string>{
            "run", photos + "2", (folder / "moved").string()},
        {"plan", (folder / "moved").string(), "--images", photos + "2"}}) {
    outcome = Call(mistyped);
    EXPECT_EQ(outcome.code, 3);
    EXPECT_THAT(outcome.text, HasSubstr("no such folder of photos"));
  }
}

}  // namespace
}  // namespace freegs
