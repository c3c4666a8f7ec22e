// SPDX-License-Identifier: BSD-3-Clause
// What the runner makes of failures, interruptions and kills.

#include <chrono>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/stage_output.h"
#include "pipeline/stage_runner.h"
#include "pipeline/workspace.h"
#include "tests/pipeline/stage_runner_fixture.h"

namespace freegs::pipeline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

TEST_F(StageRunnerTest, FailureStopsAndIsRemembered) {
  b_.act = [](StageContext&) { return UnusableResultError("blurred; retake"); };
  const Status status = Run();
  EXPECT_EQ(status.code(), StatusCode::kUnusableResult);
  EXPECT_EQ(status.message(), "b: blurred; retake");
  EXPECT_EQ(Runs(), "110");
  std::vector<StageReport> reports = Inspect();
  EXPECT_EQ(reports[0].state.status, StageStatus::kDone);
  EXPECT_EQ(reports[1].state.status, StageStatus::kFailed);
  EXPECT_EQ(reports[1].state.reason, "blurred; retake");
  EXPECT_EQ(reports[2].state.status, StageStatus::kMissing);

  b_.act = nullptr;
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "121");
  EXPECT_FALSE(b_.resumed);
}

TEST_F(StageRunnerTest, TheStageIsNamedBeforeWhatItSays) {
  b_.act = [](StageContext& context) {
    context.log(LogLevel::kInfo, "one");
    context.log(LogLevel::kInfo, "two");
    return UnusableResultError("no");
  };
  EXPECT_EQ(Run().message(), "b: no");
  EXPECT_THAT(log_, HasSubstr("\nb: one\nb: two\n"));
}

// Trained for a while, interrupted, and then the disk is full for two runs.
TEST_F(StageRunnerTest, FailuresOfTheMachineKeepWhatWasSaved) {
  b_.act = [this](StageContext& context) {
    WriteText(context.output / "checkpoint", "half");
    cancellation_->Cancel();
    return InterruptedError("stopped");
  };
  EXPECT_EQ(Run().code(), StatusCode::kInterrupted);
  b_.act = [](StageContext&) { return InternalError("disk full"); };
  for (int i = 0; i < 2; ++i) {
    const Status status = Run();
    EXPECT_EQ(status.code(), StatusCode::kInternal);
    EXPECT_THAT(status.message(), HasSubstr("disk full\n"));
    EXPECT_THAT(status.message(), HasSubstr("b.partial"));
    EXPECT_TRUE(b_.resumed);
    EXPECT_TRUE(Inspect()[1].state.resumable);
  }
  b_.act = nullptr;
  ASSERT_TRUE(Run().ok());
  EXPECT_TRUE(b_.resumed);
  EXPECT_THAT(log_, HasSubstr("b: trying again where it failed\n"));
  EXPECT_EQ(ReadText(workspace() / "b" / "checkpoint"), "half");
}

TEST_F(StageRunnerTest, VerdictsStartAnew) {
  for (const Status& verdict :
       {BadInputError("a damaged database"), UnusableResultError("no model")}) {
    b_.act = [&](StageContext& context) {
      EXPECT_FALSE(fs::exists(context.output / "rest"));
      WriteText(context.output / "rest", "");
      return verdict;
    };
    EXPECT_EQ(Run().code(), verdict.code());
    EXPECT_EQ(Run().code(), verdict.code());
    EXPECT_FALSE(b_.resumed);
  }
}

TEST_F(StageRunnerTest, ThrowingStageIsAnError) {
  b_.act = [](StageContext&) -> Status { throw std::runtime_error("oops"); };
  const Status status = Run();
  EXPECT_EQ(status.code(), StatusCode::kInternal);
  EXPECT_THAT(status.message(), HasSubstr("oops"));
  b_.act = [](StageContext&) -> Status { throw std::bad_alloc(); };
  EXPECT_THAT(Run().message(), HasSubstr("out of memory"));
}

TEST_F(StageRunnerTest, FailedRedoKeepsTheOldResult) {
  ASSERT_TRUE(Run().ok());
  b_.option = "2";
  b_.act = [](StageContext&) { return UnusableResultError("no"); };
  ASSERT_FALSE(Run().ok());
  EXPECT_EQ(ReadText(workspace() / "b" / "out.txt"), "b1");
  EXPECT_EQ(Inspect()[1].state.status, StageStatus::kFailed);
  // With the old option the old result holds.
  b_.option = "1";
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "121");
}

TEST_F(StageRunnerTest, CancelledStageIsContinued) {
  b_.act = [this](StageContext& context) {
    cancellation_->Cancel();
    WriteText(context.output / "checkpoint", "half");
    return InterruptedError("stopped");
  };
  const Status status = Run();
  EXPECT_EQ(status.code(), StatusCode::kInterrupted);
  EXPECT_THAT(
      status.message(),
      HasSubstr("stage b; the same command goes on from what is saved"));
  EXPECT_EQ(Inspect()[1].state.status, StageStatus::kInterrupted);
  EXPECT_TRUE(Inspect()[1].state.resumable);

  b_.act = [](StageContext& context) {
    EXPECT_EQ(ReadText(context.output / "checkpoint"), "half");
    EXPECT_FALSE(fs::exists(context.output / "stage.json"));
    return Status();
  };
  ASSERT_TRUE(Run().ok());
  EXPECT_TRUE(b_.resumed);
  EXPECT_GT(b_.earlier_seconds, 0);
  EXPECT_EQ(Runs(), "121");
  EXPECT_THAT(log_, HasSubstr("b: continuing an interrupted run\n"));
  EXPECT_TRUE(ReadStageRecord(workspace() / "b")->resumed);
}

TEST_F(StageRunnerTest, AnyErrorOfACancelledStageIsAnInterruption) {
  b_.act = [this](StageContext&) {
    cancellation_->Cancel();
    return UnusableResultError("a child process died");
  };
  const Status status = Run();
  EXPECT_EQ(status.code(), StatusCode::kInterrupted);
  EXPECT_THAT(status.message(), HasSubstr("a child process died"));
}

TEST_F(StageRunnerTest, CancelledBetweenStages) {
  b_.act = [this](StageContext&) {
    cancellation_->Cancel();
    return Status();
  };
  EXPECT_EQ(Run().code(), StatusCode::kInterrupted);
  EXPECT_TRUE(fs::exists(workspace() / "b" / "stage.json"));
  b_.act = nullptr;
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
}

TEST_F(StageRunnerTest, CancelledWhileTheInputsAreRead) {
  a_.asked = [this] { cancellation_->Cancel(); };
  const Status status = Run();
  EXPECT_EQ(status.code(), StatusCode::kInterrupted);
  EXPECT_THAT(status.message(), HasSubstr("interrupted before stage a; "));
  EXPECT_EQ(Runs(), "000");
  a_.asked = nullptr;
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");

  // The photo, which is old enough then, is read first. It is remembered.
  std::this_thread::sleep_for(std::chrono::milliseconds(2100));
  fs::remove(FingerprintCachePath(workspace()));
  b_.asked = [this] { cancellation_->Cancel(); };
  EXPECT_EQ(Run().code(), StatusCode::kInterrupted);
  EXPECT_THAT(ReadText(FingerprintCachePath(workspace())), HasSubstr("1.jpg"));
  b_.asked = nullptr;
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
}

TEST_F(StageRunnerTest, KilledStageIsContinued) {
  KillDuringB();
  EXPECT_TRUE(fs::exists(workspace() / "b.partial" / "checkpoint"));
  EXPECT_TRUE(fs::exists(workspace() / "b.partial" / "usage.json"));
  ASSERT_TRUE(WritePartialUsage(workspace() / "b.partial",
                                {.wall_seconds = 40, .cpu_seconds = 90})
                  .ok());
  EXPECT_TRUE(fs::exists(ProgressPath(workspace())));
  WriteText(PreviewPath(workspace()), "a picture of the killed run");
  // From the beginning of the next run, also before its first stage.
  b_.need = [this](const StageContext&) {
    EXPECT_FALSE(fs::exists(ProgressPath(workspace())));
    EXPECT_FALSE(fs::exists(PreviewPath(workspace())));
    return StageNeed();
  };
  ASSERT_TRUE(Run().ok());
  EXPECT_TRUE(b_.resumed);
  EXPECT_EQ(b_.earlier_seconds, 40);
  EXPECT_EQ(b_.earlier_cpu_seconds, 90);
  EXPECT_TRUE(fs::exists(workspace() / "b" / "checkpoint"));
}

TEST_F(StageRunnerTest, KilledStageWithOtherOptionsStartsAnew) {
  KillDuringB();
  b_.option = "2";
  ASSERT_TRUE(Run().ok());
  EXPECT_FALSE(b_.resumed);
  EXPECT_FALSE(fs::exists(workspace() / "b" / "checkpoint"));
  EXPECT_THAT(log_, HasSubstr("option b.option changed 1 -> 2"));
}

// As where a disk was not mounted that holds a model.
TEST_F(StageRunnerTest, WhatAKilledStageSavedIsKeptUntilItsInputIsBack) {
  const fs::path model = folder_ / "model.json";
  WriteText(model, "model");
  b_.inputs.push_back(model);
  KillDuringB();
  fs::rename(model, folder_ / "away");
  const int runs = b_.runs;
  const Status status = Run();
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("b: input model.json is missing"));
  EXPECT_THAT(status.message(),
              HasSubstr("delete " + (workspace() / "b.partial").string()));
  EXPECT_THAT(Inspect()[1].state.reason,
              HasSubstr("saved is kept until it is there again"));
  EXPECT_EQ(b_.runs, runs);
  // A path that was never read, either: it may be mistyped.
  b_.inputs.back() = folder_ / "modle.json";
  EXPECT_EQ(Run().code(), StatusCode::kBadInput);
  EXPECT_EQ(b_.runs, runs);
  b_.inputs.back() = model;
  fs::rename(folder_ / "away", model);
  ASSERT_TRUE(Run().ok());
  EXPECT_TRUE(b_.resumed);
  EXPECT_EQ(ReadText(workspace() / "b" / "checkpoint"), "half");
}

// What was saved is of no use with other options, so nothing waits for it.
TEST_F(StageRunnerTest, WithOtherOptionsNothingWaitsForAnInput) {
  const fs::path model = folder_ / "model.json";
  WriteText(model, "model");
  b_.inputs.push_back(model);
  KillDuringB();
  fs::remove(model);
  b_.option = "2";
  ASSERT_TRUE(Run().ok());
  EXPECT_FALSE(b_.resumed);
}

TEST_F(StageRunnerTest, KilledBeforeTheFingerprintWasWritten) {
  KillDuringB();
  for (const char* content : {"", "{", "[]", "{\"stage\": 3}"}) {
    WriteText(workspace() / "b.partial" / "partial.json", content);
    EXPECT_FALSE(Inspect()[1].state.resumable) << content;
  }
  fs::remove(workspace() / "b.partial" / "partial.json");
  ASSERT_TRUE(Run().ok());
  EXPECT_FALSE(b_.resumed);
  EXPECT_FALSE(fs::exists(workspace() / "b" / "checkpoint"));
}

TEST_F(StageRunnerTest, KilledForcedRedoIsContinuedByRun) {
  ASSERT_TRUE(Run().ok());
  b_.act = [this](StageContext& context) {
    WriteText(context.output / "checkpoint", "half");
    cancellation_->Cancel();
    return InterruptedError("stopped");
  };
  EXPECT_EQ(Run("b").code(), StatusCode::kInterrupted);
  EXPECT_EQ(ReadText(workspace() / "b" / "out.txt"), "b1");
  b_.act = nullptr;
  ASSERT_TRUE(Run().ok());
  EXPECT_TRUE(b_.resumed);
}

// Every state a kill between two steps of replacing b can leave.
TEST_F(StageRunnerTest, KilledWhileReplacingAResult) {
  ASSERT_TRUE(Run().ok());
  const fs::path old_b = folder_ / "old";
  fs::copy(workspace() / "b", old_b, fs::copy_options::recursive);
  b_.option = "2";
  ASSERT_TRUE(Run().ok());
  const fs::path new_b = folder_ / "new";
  fs::rename(workspace() / "b", new_b);
  const int runs = b_.runs;
  const auto place = [&](const fs::path& from, const std::string& name) {
    fs::copy(from, workspace() / name, fs::copy_options::recursive);
  };
  const auto check = [&](const char* what) {
    ASSERT_TRUE(Run().ok()) << what;
    EXPECT_EQ(b_.runs, runs) << what;
    EXPECT_EQ(ReadText(workspace() / "b" / "out.txt"), "b2") << what;
    EXPECT_FALSE(fs::exists(workspace() / "b.old")) << what;
    EXPECT_FALSE(fs::exists(workspace() / "b.partial")) << what;
    EXPECT_FALSE(fs::exists(workspace() / "b" / "partial.json")) << what;
    EXPECT_FALSE(fs::exists(workspace() / "b" / "usage.json")) << what;
    fs::remove_all(workspace() / "b");
  };
  // After step 1: the record is written.
  place(old_b, "b");
  place(new_b, "b.partial");
  WriteText(workspace() / "b.partial" / "partial.json", "{}");
  WriteText(workspace() / "b.partial" / "usage.json", "{}");
  check("record written");
  // With something left of an earlier replacement besides.
  place(old_b, "b");
  place(new_b, "b.partial");
  WriteText(workspace() / "b.old" / "rest", "");
  check("record written, rest of an older result");
  // After step 2: the old result has moved away.
  place(old_b, "b.old");
  place(new_b, "b.partial");
  check("old moved away");
  // After step 3: the new one has taken its place.
  place(new_b, "b");
  place(old_b, "b.old");
  check("new in place");
  // During step 4.
  place(new_b, "b");
  WriteText(workspace() / "b.old" / "rest", "");
  check("old half deleted");
}

// As in the store of a bench, whose workspaces share results by links.
TEST_F(StageRunnerTest, ReplacingALinkedResultLeavesItsTargetAlone) {
  ASSERT_TRUE(Run().ok());
  const fs::path elsewhere = folder_ / "elsewhere";
  fs::rename(workspace() / "b", elsewhere);
  fs::create_directory_symlink("../elsewhere", workspace() / "b");
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
  b_.option = "2";
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(b_.runs, 2);
  EXPECT_FALSE(fs::is_symlink(workspace() / "b"));
  EXPECT_EQ(ReadText(workspace() / "b" / "out.txt"), "b2");
  EXPECT_FALSE(fs::exists(fs::symlink_status(workspace() / "b.old")));
  EXPECT_EQ(ReadText(elsewhere / "out.txt"), "b1");
  EXPECT_TRUE(ReadStageRecord(elsewhere).ok());
}

TEST_F(StageRunnerTest, ALinkThatLeadsNowhereIsReplaced) {
  fs::create_directory_symlink("nowhere", workspace() / "b");
  fs::create_directory_symlink("nowhere", workspace() / "b.old");
  const Status status = Run();
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(Runs(), "111");
  EXPECT_EQ(ReadText(workspace() / "b" / "out.txt"), "b1");
  EXPECT_FALSE(fs::exists(fs::symlink_status(workspace() / "b.old")));
}

TEST_F(StageRunnerTest, RetiredResultComesBackIfTheNewOneIsLost) {
  ASSERT_TRUE(Run().ok());
  fs::rename(workspace() / "b", workspace() / "b.old");
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
  // But not one that was already being deleted.
  fs::rename(workspace() / "b", workspace() / "b.old");
  fs::remove(workspace() / "b.old" / "stage.json");
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "122");
}

// As with a file of another user in it: a folder cannot be deleted as a file.
TEST_F(StageRunnerTest, OldResultThatCannotBeDeleted) {
  ASSERT_TRUE(Run().ok());
  WriteText(workspace() / "b.old" / "stage.json" / "file", "");
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "111");
  b_.option = "2";
  for (int i = 0; i < 2; ++i) {
    const Status status = Run();
    EXPECT_EQ(status.code(), StatusCode::kInternal);
    EXPECT_THAT(status.message(), HasSubstr("b.old"));
    EXPECT_THAT(status.message(), HasSubstr("delete it yourself"));
    EXPECT_EQ(ReadText(workspace() / "b" / "out.txt"), "b1");
  }
  fs::remove_all(workspace() / "b.old");
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "122");
  EXPECT_EQ(ReadText(workspace() / "b" / "out.txt"), "b2");
}

}  // namespace
}  // namespace freegs::pipeline
