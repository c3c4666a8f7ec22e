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

TEST_F(StageRunnerTest, WhatAnInterruptedRunSavedBesideAResultIsTold) {
  ASSERT_TRUE(Run().ok());
  const fs::path partial = workspace() / "b.partial";
  fs::copy(workspace() / "a", partial);  // The fingerprint is of another run.
  b_.version = 2;
  EXPECT_THAT(Inspect()[1].state.note,
              HasSubstr("what an interrupted run of it saved does not fit"));
  b_.version = 1;
  EXPECT_EQ(Inspect()[1].state.note, "");
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
