// SPDX-License-Identifier: BSD-3-Clause
// Runs the commands of the pages on a small drawn scene: the blocks that begin
// with ```sh test, one page after the other, in a folder that has `photos`.
// Then looks whether docs/workspace.md names all that came of it.

#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/image_io.h"
#include "core/parallel.h"
#include "tests/docs/pages.h"
#include "tests/docs/workspace_page.h"
#include "tests/scene_maker/scene.h"
#include "tests/scene_maker/scene_files.h"
#include "tests/temporary_folder.h"

namespace freegs::docs {
namespace {

namespace fs = std::filesystem;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

// What the pages begin with: "photos", their truth in "truth", and options that
// make a run short, in the config.ini of the workspace "scene".
Status MakeFolder(const fs::path& folder) {
  scene_maker::SceneMakerOptions options;
  options.views = 12;
  options.test_views = 2;
  options.width = 240;
  options.height = 180;
  FREEGS_ASSIGN_OR_RETURN(const scene_maker::Scene scene,
                          scene_maker::BuildScene(options));
  ThreadPool pool;
  FREEGS_RETURN_IF_ERROR(
      scene_maker::WriteScene(scene, folder / "truth", pool, {}));
  fs::copy(folder / "truth" / "images", folder / "photos");
  WriteText(folder / "scene" / "config.ini",
            "[general]\nthreads = 1\n"
            "[reconstruct]\niterations = 200\nbudget = 2000\n");
  return Status();
}

class RunPagesTest : public ::testing::Test {
 protected:
  // Runs a script with the built program first in PATH. Returns what it printed
  // if it failed, which is never empty then.
  std::string Complaint(const std::string& script) {
    const fs::path log = folder_ / "log.txt";
    WriteText(folder_ / "script.sh",
              "set -e\nPATH='" +
                  fs::path(FREEGS_PROGRAM).parent_path().string() +
                  "':$PATH\ncd \"${0%/*}\"\n" + script + "\n");
    const std::string command = "bash '" + (folder_ / "script.sh").string() +
                                "' >'" + log.string() + "' 2>&1 </dev/null";
    if (std::system(command.c_str()) == 0) return "";
    const std::string printed = ReadText(log);
    return printed.empty() ? "failed without a word" : printed;
  }

  TemporaryFolder folder_;
};

TEST_F(RunPagesTest, CommandsDoWhatThePagesSay) {
  if (!Complaint("command -v colmap").empty()) {
    GTEST_SKIP() << "COLMAP is not installed";
  }
  ASSERT_EQ(Complaint("freegs_pipeline doctor"), "");
  const Status made = MakeFolder(folder_.path());
  ASSERT_TRUE(made.ok()) << made.message();
  std::set<std::string> commands;
  for (const Page& page : ReadPages(SourceFolder())) {
    for (const CodeBlock& block : page.blocks) {
      if (block.info != "sh test") continue;
      std::string script;
      for (const std::string& line : block.lines) script += line + "\n";
      EXPECT_EQ(Complaint(script), "") << page.path << ":\n" << script;
      for (const std::vector<std::string>& words : ShellCommands(block)) {
        if (words.size() > 1 && words[0] == "freegs_pipeline") {
          commands.insert(words[1]);
        }
      }
    }
  }
  for (const char* command : {"run",
                              "status",
                              "query",
                              "render",
                              "export",
                              "eval",
                              "doctor",
                              "manual"}) {
    EXPECT_TRUE(commands.contains(command)) << "no page runs " << command;
  }

  // A second workspace has what the first has not: masks, imported poses,
  // learnt exposure, training of the semantic field, clusters in the union
  // space.
  ImageU8 mask(240, 180, 1);
  for (size_t k = 0; k < mask.size() / 2; ++k) mask.data()[k] = 255;
  fs::create_directories(folder_ / "photos/masks");
  ASSERT_TRUE(
      WriteImage(folder_ / "photos/masks/frame_0003.jpg.png", mask).ok());
  EXPECT_EQ(Complaint("freegs_pipeline init other\n"
                      "freegs_pipeline run photos other --sfm.import "
                      "truth/gt/transforms.json --sfm.random_points 10000 "
                      "--threads 1 --reconstruct.iterations 200 "
                      "--reconstruct.exposure on "
                      "--bootstrap.mode paper --bootstrap.iterations 40 "
                      "--bootstrap.clustering union"),
            "");

  WorkspacePage page(SourceFolder() / "docs" / "workspace.md");
  for (const char* workspace : {"scene", "other"}) {
    page.Compare(folder_ / workspace);
  }
  EXPECT_THAT(page.unnamed(), IsEmpty());
  // What is there only while a stage runs, after it failed, with a film, a
  // digital zoom or a lens that distorts, or with the workflow for many scenes.
  EXPECT_THAT(page.Missing(),
              UnorderedElementsAre(".workflow/",
                                   "STAGE.partial/partial.json",
                                   "STAGE.partial/usage.json",
                                   "STAGE/stage.json: error",
                                   "ingest.partial/frames/PHOTO",
                                   "ingest.partial/pending/N.png",
                                   "ingest/images.json: digital_zoom",
                                   "ingest/images.json: film",
                                   "ingest/images.json: frame",
                                   "ingest/images.json: time_s",
                                   "preview.jpg",
                                   "progress.json",
                                   "sfm.partial/attempts/",
                                   "sfm.partial/steps.json",
                                   "undistort/logs/*.log"));
}

}  // namespace
}  // namespace freegs::docs
