// SPDX-License-Identifier: BSD-3-Clause
// Which stages the runner skips and redoes, and why.

#include "pipeline/stage_runner.h"

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/pipeline/stage_runner_fixture.h"

namespace freegs::pipeline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(StageRunnerTest, RunsAllThenSkipsAll) {
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
  EXPECT_EQ(ReadText(workspace() / "b" / "out.txt"), "b1");
  const StatusOr<StageRecord> record = ReadStageRecord(workspace() / "b");
  ASSERT_TRUE(record.ok());
  EXPECT_EQ(record->outcome, StageOutcome::kDone);
  EXPECT_EQ(record->summary["letters"], 2);
  EXPECT_FALSE(fs::exists(workspace() / "b" / "partial.json"));
  EXPECT_FALSE(fs::exists(workspace() / "b" / "usage.json"));
  EXPECT_FALSE(fs::exists(workspace() / "b.partial"));

  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
  EXPECT_EQ(log_, "a: up to date\nb: up to date\nc: up to date\n");
}

TEST_F(StageRunnerTest, ChangedOptionRedoesItAndAllThatFollow) {
  ASSERT_TRUE(Run().ok());
  b_.option = "2";
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "122");
  EXPECT_THAT(log_, HasSubstr("b: option b.option changed 1 -> 2\n"));
  EXPECT_THAT(log_, HasSubstr("c: input b/out.txt changed\n"));
  EXPECT_EQ(ReadText(workspace() / "b" / "out.txt"), "b2");
  EXPECT_FALSE(fs::exists(workspace() / "b.old"));
}

TEST_F(StageRunnerTest, ChangedVersionOrInputRedoes) {
  ASSERT_TRUE(Run().ok());
  c_.version = 2;
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "112");
  EXPECT_THAT(log_, HasSubstr("c: this program's version"));

  WriteText(images() / "2.jpg", "another photo");
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "223");
  EXPECT_THAT(log_, HasSubstr("a: input photos changed (1 file -> 2 files)\n"));
}

TEST_F(StageRunnerTest, WhatFollowsIsRedoneEvenIfItsInputIsTheSame) {
  ASSERT_TRUE(Run().ok());
  b_.version = 2;
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "122");
  EXPECT_THAT(log_, HasSubstr("c: stage b was redone\n"));
}

TEST_F(StageRunnerTest, SwappedOutputRedoesWhatFollows) {
  ASSERT_TRUE(Run().ok());
  WriteText(workspace() / "b" / "out.txt", "somebody else's");
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "112");
  EXPECT_THAT(log_, HasSubstr("warning: b: out.txt: not as the stage wrote"));
  EXPECT_THAT(log_, HasSubstr("c: input b/out.txt changed\n"));
}

TEST_F(StageRunnerTest, DeletedOutputIsMadeAgain) {
  ASSERT_TRUE(Run().ok());
  fs::remove(workspace() / "b" / "out.txt");
  EXPECT_EQ(Inspect()[1].state.status, StageStatus::kStale);
  ASSERT_TRUE(Run().ok());
  // The content is the same again, so what follows still holds.
  EXPECT_EQ(Runs(), "121");
  EXPECT_THAT(log_, HasSubstr("b: out.txt: missing or empty\n"));
  WriteText(workspace() / "a" / "out.txt", "");
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "221");
}

TEST_F(StageRunnerTest, DeletedOutputThatNoStageReadsIsTold) {
  c_.act = [](StageContext& context) {
    WriteText(context.output / "masks" / "1.png", "x");
    WriteText(context.output / "cache" / "1", "x");
    return Status();
  };
  ASSERT_TRUE(Run().ok());
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(log_, Not(HasSubstr("deleted")));
  fs::remove_all(workspace() / "c" / "cache");
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(log_, Not(HasSubstr("deleted")));
  fs::remove_all(workspace() / "c" / "masks");
  fs::remove(workspace() / "c" / "out.txt");
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
  EXPECT_THAT(
      log_,
      HasSubstr("warning: c: masks, out.txt: deleted (to make it again: "
                "freegs_pipeline stage c "));
}

// Masks, for instance: a stage that reads them has no such input before they
// are in place.
TEST_F(StageRunnerTest, AnOutputThatIsReadIfItIsThere) {
  c_.optional_input = "b/masks";
  b_.act = [](StageContext& context) {
    WriteText(context.output / "masks" / "1.png", "own");
    return Status();
  };
  ASSERT_TRUE(Run().ok());
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
  EXPECT_THAT(log_, Not(HasSubstr("not as the stage wrote")));
  WriteText(workspace() / "b" / "masks" / "1.png", "somebody else's");
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "112");
  EXPECT_THAT(log_, HasSubstr("b: masks/1.png: not as the stage wrote it"));
}

TEST_F(StageRunnerTest, WhatFileManagersLeaveHidesNoLoss) {
  c_.inputs = {"b/out.txt", "b/model"};
  b_.act = [](StageContext& context) {
    WriteText(context.output / "model" / "a.bin", "own");
    return Status();
  };
  ASSERT_TRUE(Run().ok());
  const fs::path folder = workspace() / "b" / "model";
  WriteText(folder / "Thumbs.db", "");
  WriteText(folder / ".thumbnails" / "a.png", "");
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
  fs::remove(folder / "a.bin");
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs().substr(0, 2), "12");
  EXPECT_THAT(log_, Not(HasSubstr("not as the stage wrote")));
}

// Somebody else's result in another format.
TEST_F(StageRunnerTest, ReplacedFilesAreNotOverwritten) {
  workspace_ = folder_ / "my scene";
  c_.inputs = {"b/out.txt", "b/model"};
  b_.act = [](StageContext& context) {
    WriteText(context.output / "model" / "a.bin", "own");
    return Status();
  };
  ASSERT_TRUE(Run().ok());
  fs::rename(workspace() / "b" / "model" / "a.bin",
             workspace() / "b" / "model" / "a.txt");
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "112");
  EXPECT_THAT(log_, HasSubstr("b: model/a.txt: not as the stage wrote it"));
  EXPECT_THAT(log_,
              HasSubstr("(to make it again: freegs_pipeline stage b '" +
                        workspace().string() + "')"));
  fs::remove(workspace() / "b" / "model" / "a.txt");
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "123");
}

TEST_F(StageRunnerTest, ForeignFolderIsNeverOverwritten) {
  WriteText(workspace() / "b" / "out.txt", "somebody else's");
  const Status status = Run();
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("--from"));
  EXPECT_THAT(status.message(),
              HasSubstr("the folder " + (workspace() / "b").string() + " was"));
  EXPECT_EQ(ReadText(workspace() / "b" / "out.txt"), "somebody else's");
  EXPECT_EQ(Run("b").code(), StatusCode::kBadInput);
  from_ = "c";
  EXPECT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "101");
}

TEST_F(StageRunnerTest, FromAndTo) {
  from_ = "b";
  EXPECT_EQ(Run().code(), StatusCode::kBadInput);
  from_ = "";
  to_ = "b";
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "110");
  from_ = "c";
  EXPECT_EQ(Run().code(), StatusCode::kInvalidArgument);
  from_ = "";
  to_ = "d";
  const Status status = Run();
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), HasSubstr("a, b, c"));
}

// As with a scene of another program, of which there are no photos.
TEST_F(StageRunnerTest, FromAStageNeedsOnlyWhatTheStagesRead) {
  WriteText(workspace() / "b" / "out.txt", "somebody else's");
  from_ = "c";
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "001");
  c_.inputs.emplace_back("a/out.txt");
  const Status status = Run();
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("stage a has no result"));
}

TEST_F(StageRunnerTest, ForcedStageIsRedoneAlone) {
  ASSERT_TRUE(Run().ok());
  ASSERT_TRUE(Run("b").ok());
  EXPECT_EQ(Runs(), "121");
  EXPECT_THAT(log_, HasSubstr("b: redone as asked\n"));
  // The content is the same again, so what follows still holds.
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "121");
}

TEST_F(StageRunnerTest, PhotosMayGoOnceTheyWereRead) {
  ASSERT_TRUE(Run().ok());
  fs::remove_all(images());
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
  EXPECT_THAT(log_, HasSubstr("a: input photos is gone"));
}

TEST_F(StageRunnerTest, PhotosAndMasksInTheWorkspaceMayGoToo) {
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
TEST_F(StageRunnerTest, AnEmptyFolderOfPhotosCountsAsGone) {
  ASSERT_TRUE(Run().ok());
  fs::remove_all(images());
  fs::create_directory(images());
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
  EXPECT_THAT(log_, HasSubstr("a: input photos is gone"));
}

TEST_F(StageRunnerTest, AllInputsThatAreGoneAreNamed) {
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
TEST_F(StageRunnerTest, AnInputThatWasNeverReadIsNotGone) {
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

TEST_F(StageRunnerTest, InputsMayGoFromWhereTheyWereFoundLast) {
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
TEST_F(StageRunnerTest, InputsOutsideMayGoFromAWorkspaceThatIsMoved) {
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

TEST_F(StageRunnerTest, InputsMayGoFromAWorkspaceThatIsReachedThroughALink) {
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

TEST_F(StageRunnerTest, RecordsOfOlderProgramsDoNotSayWhereInputsLay) {
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
TEST_F(StageRunnerTest, AFolderMayGoOnceItsFilesWereRead) {
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
TEST_F(StageRunnerTest, PhotosMayGoTogetherWithLinksAmongThem) {
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
TEST_F(StageRunnerTest, AnInputMayNotBeDroppedBecauseThePhotosAreGone) {
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

TEST_F(StageRunnerTest, MovedWorkspaceIsUpToDate) {
  ASSERT_TRUE(Run().ok());
  TemporaryFolder elsewhere;
  fs::copy(workspace(), elsewhere / "ws", fs::copy_options::recursive);
  fs::copy(images(), elsewhere / "photos", fs::copy_options::recursive);
  fs::remove_all(workspace());
  fs::remove_all(images());
  fs::rename(elsewhere / "ws", workspace());
  fs::rename(elsewhere / "photos", images());
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
}

TEST_F(StageRunnerTest, DamagedRecordRedoes) {
  ASSERT_TRUE(Run().ok());
  for (const char* content : {"", "null", "{\"status\": \"done\"}", "[[[["}) {
    const int runs = b_.runs;
    WriteText(workspace() / "b" / "stage.json", content);
    ASSERT_TRUE(Run().ok()) << content;
    EXPECT_EQ(b_.runs, runs + 1);
    EXPECT_THAT(log_, HasSubstr("b: its stage.json is damaged"));
  }
}

TEST_F(StageRunnerTest, InspectionNamesWhatFollowsAsStale) {
  ASSERT_TRUE(Run().ok());
  a_.option = "2";
  const std::vector<StageReport> reports = Inspect();
  EXPECT_EQ(reports[0].state.reason, "option a.option changed 1 -> 2");
  EXPECT_EQ(reports[1].state.status, StageStatus::kStale);
  EXPECT_EQ(reports[1].state.reason, "stage a is not done");
  EXPECT_EQ(Runs(), "111");
}

}  // namespace
}  // namespace freegs::pipeline
