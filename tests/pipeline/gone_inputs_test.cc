// SPDX-License-Identifier: BSD-3-Clause
// What a run makes of inputs that are gone since a stage read them.

#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/stage_runner.h"
#include "tests/pipeline/stage_runner_fixture.h"

namespace freegs::pipeline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

using GoneInputsTest = StageRunnerTest;

TEST_F(GoneInputsTest, PhotosMayGoOnceTheyWereRead) {
  ASSERT_TRUE(Run().ok());
  fs::remove_all(images());
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
  EXPECT_THAT(log_, HasSubstr("a: input photos is gone"));
}

// Nothing is kept if the stage has to run for another reason.
TEST_F(GoneInputsTest, PhotosThatAreGoneAreWantedByANewVersion) {
  ASSERT_TRUE(Run().ok());
  fs::remove_all(images());
  a_.version = 2;
  const StageState state = Inspect()[0].state;
  EXPECT_EQ(state.status, StageStatus::kStale);
  EXPECT_THAT(state.note, HasSubstr("input photos is gone, and the stage"));
  EXPECT_THAT(state.note, HasSubstr("--from"));
  EXPECT_THAT(state.note, Not(HasSubstr("keeping")));
  a_.version = 1;
  EXPECT_THAT(Inspect()[0].state.note, HasSubstr("keeping"));
  fs::remove(workspace() / "a" / "out.txt");
  EXPECT_THAT(Inspect()[0].state.note, Not(HasSubstr("keeping")));
}

TEST_F(GoneInputsTest, PhotosAndMasksInTheWorkspaceMayGoToo) {
  images_ = workspace() / "photos";
  WriteText(images() / "1.jpg", "photo");
  const fs::path masks = workspace() / "masks";
  WriteText(masks / "1.png", "mask");
  a_.inputs = {masks};
  ASSERT_TRUE(Run().ok());
  // So a workspace that is moved still has it.
  EXPECT_EQ(
      ReadStageRecord(workspace() / "a")->fingerprint.inputs.at("photos").path,
      "photos");
  fs::remove_all(images());
  fs::remove_all(masks);
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
  EXPECT_THAT(log_, HasSubstr("a: inputs masks, photos are gone"));
}

// As where a card was mounted that holds the photos.
TEST_F(GoneInputsTest, AnEmptyFolderOfPhotosCountsAsGone) {
  ASSERT_TRUE(Run().ok());
  fs::remove_all(images());
  fs::create_directory(images());
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
  EXPECT_THAT(log_, HasSubstr("a: input photos is gone"));
}

TEST_F(GoneInputsTest, AllInputsThatAreGoneAreNamed) {
  const fs::path list = folder_ / "list.txt";
  WriteText(list, "1.jpg");
  a_.inputs = {list};
  ASSERT_TRUE(Run().ok());
  fs::remove_all(images());
  fs::remove(list);
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
  EXPECT_THAT(log_,
              HasSubstr("a: inputs list.txt, photos are gone; keeping the "
                        "result made from them\n"));
}

// It was mistyped. The stage runs, and says so itself.
TEST_F(GoneInputsTest, AnInputThatWasNeverReadIsNotGone) {
  const fs::path list = folder_ / "list.txt";
  WriteText(list, "1.jpg");
  b_.inputs = {"a/out.txt", list};
  ASSERT_TRUE(Run().ok());
  const auto refused = [&](size_t stage, const std::string& reason) {
    const StageState state = Inspect()[stage].state;
    EXPECT_EQ(state.status, StageStatus::kStale);
    EXPECT_EQ(state.reason, reason);
    EXPECT_EQ(state.note, "");
  };
  for (const char* name : {"lits.txt", "other/list.txt"}) {
    b_.inputs.back() = folder_ / name;
    refused(1, "input " + b_.inputs.back().filename().string() + " is missing");
  }
  // The one that was read may be gone, also beside a mistyped one.
  fs::remove(list);
  b_.inputs.back() = list;
  EXPECT_EQ(Inspect()[1].state.status, StageStatus::kDone);
  b_.inputs.push_back(folder_ / "more.txt");
  EXPECT_EQ(Inspect()[1].state.reason, "input more.txt is missing");
  // A stage that read no such input before.
  c_.inputs.push_back(folder_ / "scane.ply");
  b_.inputs.pop_back();
  refused(2, "input scane.ply is missing");
  c_.inputs.pop_back();

  images_ = folder_ / "none";
  refused(0, "input photos is missing");
  images_ = folder_ / "empty";
  fs::create_directory(images_);
  refused(0, "input photos changed (1 file -> 0 files)");
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(a_.runs, 2);
}

TEST_F(GoneInputsTest, InputsMayGoFromWhereTheyWereFoundLast) {
  ASSERT_TRUE(Run().ok());
  fs::rename(images_, folder_ / "moved");
  images_ = folder_ / "moved";
  ASSERT_TRUE(Run().ok());
  const auto record = ReadStageRecord(workspace() / "a");
  ASSERT_TRUE(record.ok());
  EXPECT_EQ(record->fingerprint.inputs.at("photos").path, images_);
  EXPECT_EQ(record->summary["letters"], 2);
  fs::remove_all(images_);
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
  EXPECT_THAT(log_, HasSubstr("a: input photos is gone"));
}

// As with a path in config.ini that starts with "..", and one on the command
// line.
TEST_F(GoneInputsTest, InputsOutsideMayGoFromAWorkspaceThatIsMoved) {
  WriteText(folder_ / "list.txt", "1.jpg");
  const auto name_list = [this] {
    b_.inputs = {"a/out.txt", workspace() / ".." / "list.txt"};
  };
  name_list();
  ASSERT_TRUE(Run().ok());
  const auto list = [this] {
    return ReadStageRecord(workspace() / "b")
        ->fingerprint.inputs.at("list.txt");
  };
  EXPECT_EQ(list().path, folder_ / "list.txt");
  EXPECT_EQ(list().from_workspace, "../list.txt");
  const auto move_to = [this](const std::string& parent) {
    const fs::path moved = folder_ / parent / "ws";
    fs::create_directory(moved.parent_path());
    fs::rename(workspace(), moved);
    workspace_ = moved;
  };
  move_to("first");
  const auto expect_gone = [this] {
    const StageState state = Inspect()[1].state;
    EXPECT_EQ(state.status, StageStatus::kDone) << state.reason;
    EXPECT_THAT(state.note, HasSubstr("input list.txt is gone"));
  };
  name_list();
  expect_gone();
  b_.inputs.back() = folder_ / "first" / "lits.txt";
  EXPECT_EQ(Inspect()[1].state.status, StageStatus::kStale);
  b_.inputs.back() = folder_ / "list.txt";
  EXPECT_EQ(Inspect()[1].state.note, "");
  fs::remove(folder_ / "list.txt");
  expect_gone();

  // It is found in the new place, and the workspace is moved once more.
  WriteText(folder_ / "first" / "list.txt", "1.jpg");
  name_list();
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(list().path, folder_ / "first" / "list.txt");
  move_to("second");
  name_list();
  expect_gone();
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
}

TEST_F(GoneInputsTest, InputsMayGoFromAWorkspaceThatIsReachedThroughALink) {
  fs::create_directory_symlink(folder_.path(), folder_ / "link");
  const fs::path direct = workspace();
  const fs::path linked = folder_ / "link" / "ws";
  for (const auto& [workspace, photos] :
       {std::pair{direct, linked / "photos"}, {direct, direct / "photos"}}) {
    workspace_ = workspace;
    images_ = photos;
    WriteText(images() / "1.jpg", "photo");
    ASSERT_TRUE(Run().ok());
    fs::remove_all(images());
    for (const fs::path& now : {direct, linked}) {
      workspace_ = now;
      for (const fs::path& place : {direct, linked}) {
        images_ = place / "photos";
        ASSERT_TRUE(Run().ok());
        EXPECT_THAT(log_, HasSubstr("a: input photos is gone"));
      }
    }
  }
  EXPECT_EQ(Runs(), "111");
  images_ = linked / "photo";
  EXPECT_EQ(Inspect()[0].state.status, StageStatus::kStale);
}

TEST_F(GoneInputsTest, RecordsOfOlderProgramsDoNotSayWhereInputsLay) {
  ASSERT_TRUE(Run().ok());
  const fs::path folder = workspace() / "a";
  StatusOr<StageRecord> record = ReadStageRecord(folder);
  ASSERT_TRUE(record.ok());
  record->fingerprint.inputs.at("photos").path.clear();
  ASSERT_TRUE(WriteStageRecord(folder, *record).ok());
  fs::remove_all(images());
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
}

// A stage may read the files of a folder while it is there, and name the folder
// itself when it is not.
TEST_F(GoneInputsTest, AFolderMayGoOnceItsFilesWereRead) {
  const auto model = images().parent_path() / "model";
  WriteText(model / "cameras.txt", "c");
  b_.inputs = {"a/out.txt", model / "cameras.txt"};
  ASSERT_TRUE(Run().ok());
  fs::remove_all(model);
  b_.inputs = {"a/out.txt", model};
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
  EXPECT_THAT(log_, HasSubstr("b: input model is gone"));
  // What else changed still counts.
  a_.option = "2";
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(b_.runs, 2);
}

// A stage knows of a link in the photo folder only as long as the photo folder
// is there.
TEST_F(GoneInputsTest, PhotosMayGoTogetherWithLinksAmongThem) {
  const fs::path more = folder_ / "more";
  WriteText(more / "2.jpg", "photo");
  fs::create_directory_symlink(more, images() / "linked");
  a_.inputs = {images() / "linked" / ""};
  ASSERT_TRUE(Run().ok());
  fs::remove_all(images());
  a_.inputs.clear();
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
  EXPECT_THAT(log_, HasSubstr("a: input photos is gone"));
  EXPECT_THAT(log_, HasSubstr("a: up to date\n"));
  // What else changed still counts.
  a_.option = "2";
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(a_.runs, 2);
}

// What was given beside the photos, and is not given any more, still counts.
TEST_F(GoneInputsTest, AnInputMayNotBeDroppedBecauseThePhotosAreGone) {
  WriteText(folder_ / "list.txt", "1.jpg");
  a_.inputs = {folder_ / "list.txt"};
  ASSERT_TRUE(Run().ok());
  fs::remove_all(images());
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(a_.runs, 1);
  a_.inputs.clear();
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(a_.runs, 2);
  EXPECT_THAT(log_, HasSubstr("a: input list.txt is no longer used"));
}

}  // namespace
}  // namespace freegs::pipeline
