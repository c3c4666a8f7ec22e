// SPDX-License-Identifier: BSD-3-Clause
// The runner with stages that only write text: what it skips, redoes and why,
// and what it makes of failures, interruptions and kills.

#include "pipeline/stage_runner.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/stage_output.h"
#include "pipeline/workspace.h"
#include "tests/temporary_folder.h"

namespace freegs::pipeline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

// What a test wants of a stage, and what the stage saw.
struct Script {
  int version = 1;
  std::string option = "1";
  std::vector<fs::path> inputs;
  std::function<Status(StageContext&)> act;  // Before the output is written.
  std::function<StageNeed(const StageContext&)> need;  // But its disk_bytes.
  int runs = 0;
  bool resumed = false;
  double earlier_seconds = 0;
};

class TextStage : public Stage {
 public:
  TextStage(std::string name, Script* script)
      : name_(std::move(name)), script_(script) {}
  std::string_view name() const override { return name_; }
  int version() const override { return script_->version; }
  std::vector<fs::path> Inputs(const StageContext& context) const override {
    std::vector<fs::path> inputs = script_->inputs;
    if (name_ == "a") inputs.push_back(context.images);
    return inputs;
  }
  // Each stage makes one more Gaussian; one that is done makes ten.
  StageNeed Foretell(const StageContext& context,
                     bool done,
                     SceneOutlook* scene) const override {
    StageNeed need = script_->need ? script_->need(context) : StageNeed{};
    need.disk_bytes = scene->gaussians;
    scene->gaussians += done ? 10 : 1;
    return need;
  }
  std::vector<std::string> Disposable() const override { return {"cache"}; }
  Status Run(StageContext& context) override {
    ++script_->runs;
    script_->resumed = context.resuming;
    script_->earlier_seconds = context.earlier_seconds;
    context.progress({"writing", 1, 2, ""});
    if (script_->act) FREEGS_RETURN_IF_ERROR(script_->act(context));
    WriteText(context.output / "out.txt", name_ + script_->option);
    context.summary["letters"] = 2;
    return Status();
  }

 private:
  std::string name_;
  Script* script_;
};

class StageRunnerTest : public ::testing::Test {
 protected:
  StageRunnerTest() {
    fs::create_directory(workspace());
    WriteText(images() / "1.jpg", "photo");
    b_.inputs = {"a/out.txt"};
    c_.inputs = {"b/out.txt"};
  }

  fs::path workspace() const { return folder_ / "ws"; }
  fs::path images() const { return folder_ / "photos"; }

  StageRunner MakeRunner(Logger* logger, const std::string& forced = "") {
    std::vector<RunnerStage> stages;
    for (auto& [name, script] : {std::pair{"a", &a_}, {"b", &b_}, {"c", &c_}}) {
      RunnerStage stage;
      stage.stage = std::make_unique<TextStage>(name, script);
      stage.options = {{std::string(name) + ".option", script->option}};
      stages.push_back(std::move(stage));
    }
    StageRunnerOptions options;
    options.workspace = workspace();
    options.images = images();
    options.from = forced.empty() ? from_ : forced;
    options.to = forced.empty() ? to_ : forced;
    options.forced = forced;
    options.num_threads = 1;
    options.usage_interval_seconds = 0;
    return StageRunner(
        std::move(stages), std::move(options), *cancellation_, *logger);
  }

  Status Run(const std::string& forced = "") {
    cancellation_ = std::make_unique<CancellationToken>();
    std::ostringstream console;
    Logger logger(console, /*terminal=*/false, "");
    const Status status = MakeRunner(&logger, forced).Run();
    log_ = console.str();
    return status;
  }

  std::vector<StageReport> Inspect() {
    std::ostringstream console;
    Logger logger(console, /*terminal=*/false, "");
    StatusOr<std::vector<StageReport>> reports = MakeRunner(&logger).Inspect();
    EXPECT_TRUE(reports.ok());
    return *std::move(reports);
  }

  std::string Runs() const {
    return std::to_string(a_.runs) + std::to_string(b_.runs) +
           std::to_string(c_.runs);
  }

  // Runs b until it has written half of its work, then dies the way kill -9
  // does: nothing after the act is done. Returns the state it left.
  void KillDuringB() {
    b_.act = [this](StageContext& context) {
      WriteText(context.output / "checkpoint", "half");
      fs::copy(workspace(), folder_ / "killed", fs::copy_options::recursive);
      return Status();
    };
    EXPECT_TRUE(Run().ok());
    b_.act = nullptr;
    fs::remove_all(workspace());
    fs::rename(folder_ / "killed", workspace());
  }

  TemporaryFolder folder_;
  Script a_, b_, c_;
  std::string from_, to_;
  std::string log_;
  std::unique_ptr<CancellationToken> cancellation_ =
      std::make_unique<CancellationToken>();
};

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
  // The same content again: what follows still holds.
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
  EXPECT_THAT(log_,
              HasSubstr("warning: c: masks, out.txt: deleted ('freegs_pipeline "
                        "stage c "));
}

// Somebody else's result in another format.
TEST_F(StageRunnerTest, ReplacedFilesAreNotOverwritten) {
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
  EXPECT_THAT(log_, HasSubstr("'freegs_pipeline stage b "));
  fs::remove(workspace() / "b" / "model" / "a.txt");
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "123");
}

TEST_F(StageRunnerTest, ForeignFolderIsNeverOverwritten) {
  WriteText(workspace() / "b" / "out.txt", "somebody else's");
  const Status status = Run();
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("--from"));
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

TEST_F(StageRunnerTest, ForcedStageIsRedoneAlone) {
  ASSERT_TRUE(Run().ok());
  ASSERT_TRUE(Run("b").ok());
  EXPECT_EQ(Runs(), "121");
  EXPECT_THAT(log_, HasSubstr("b: redone as asked\n"));
  // The same content again: what follows still holds.
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

TEST_F(StageRunnerTest, TellsTheMemoryThatAStageNeeds) {
  a_.need = [](const StageContext& context) {
    return StageNeed{.memory_bytes = 1000000 * context.pool->num_threads(),
                     .seconds = 7,
                     .advice = "do less"};
  };
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(log_, HasSubstr("\na: needs about "));
  EXPECT_THAT(log_, HasSubstr(" are available\n"));
  EXPECT_THAT(log_, Not(HasSubstr("warning")));
  EXPECT_THAT(log_, Not(HasSubstr("do less")));
  EXPECT_THAT(log_, Not(HasSubstr("b: needs")));  // Nothing is known of b.
  const StatusOr<StageRecord> a = ReadStageRecord(workspace() / "a");
  EXPECT_GE(a->expected_memory_bytes, 1000000);
  EXPECT_EQ(a->expected_seconds, 7);
  EXPECT_EQ(ReadStageRecord(workspace() / "b")->expected_memory_bytes, 0);
}

TEST_F(StageRunnerTest, TellsBeforeItBeginsWhatAllStagesTake) {
  for (Script* script : {&a_, &b_, &c_}) {
    script->need = [](const StageContext&) {
      return StageNeed{.memory_bytes = 90'000'000, .seconds = 20};
    };
  }
  c_.need = nullptr;
  ASSERT_TRUE(Run().ok());
  EXPECT_TRUE(log_.starts_with(
      "run: expected to take about 40 s, 90.0 MB of memory and 3 B of disk "
      "space; nothing is known of c\n"))
      << log_;
  // Only what is needed counts.
  b_.option = "2";
  to_ = "b";
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(log_, HasSubstr("about 20 s, 90.0 MB of memory and 10 B"));
  EXPECT_THAT(log_, Not(HasSubstr("nothing is known")));
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(log_, Not(HasSubstr("expected")));
}

TEST_F(StageRunnerTest, ForecastsBuildOnWhatIsDone) {
  a_.need = [](const StageContext&) { return StageNeed{.memory_bytes = 5}; };
  const auto forecast = [this](const std::string& forced = "") {
    cancellation_ = std::make_unique<CancellationToken>();
    std::ostringstream console;
    Logger logger(console, /*terminal=*/false, "");
    return *MakeRunner(&logger, forced).Forecast();
  };
  std::vector<StageForecast> stages = forecast();
  EXPECT_TRUE(fs::is_empty(workspace()));
  ASSERT_EQ(stages.size(), 3u);
  EXPECT_EQ(stages[0].stage, "a");
  EXPECT_TRUE(stages[0].needed && stages[1].needed && stages[2].needed);
  EXPECT_EQ(stages[0].reason, "not run yet");
  EXPECT_EQ(stages[0].need.memory_bytes, 5);
  EXPECT_EQ(stages[2].need.disk_bytes, 2);
  EXPECT_TRUE(stages[0].need.from_files);
  EXPECT_FALSE(stages[1].need.from_files);

  to_ = "b";
  ASSERT_TRUE(Run().ok());
  to_ = "";
  stages = forecast();
  EXPECT_FALSE(stages[1].needed);
  EXPECT_TRUE(stages[2].needed);
  EXPECT_TRUE(stages[2].need.from_files);
  EXPECT_EQ(stages[2].need.disk_bytes, 20);
  b_.option = "2";
  stages = forecast();
  EXPECT_FALSE(stages[0].needed);
  EXPECT_EQ(stages[1].reason, "option b.option changed 1 -> 2");
  EXPECT_EQ(stages[2].need.disk_bytes, 11);
  stages = forecast("a");
  EXPECT_TRUE(stages[0].needed);
  EXPECT_EQ(stages[0].reason, "redone as asked");
  EXPECT_FALSE(stages[1].needed);
}

TEST_F(StageRunnerTest, MemoryThatIsInUseBeforeAStageCounts) {
  a_.need = [](const StageContext&) { return StageNeed{.memory_bytes = 1000}; };
  const std::vector<char> held(200'000'000, 1);
  ASSERT_TRUE(Run().ok());
  EXPECT_GT(ReadStageRecord(workspace() / "a")->expected_memory_bytes,
            100'000'000);
  EXPECT_EQ(held.back(), 1);
}

TEST_F(StageRunnerTest, WarnsOfAStageThatNeedsMoreMemoryThanThereIs) {
  b_.need = [](const StageContext&) {
    return StageNeed{.memory_bytes = int64_t{1} << 60,
                     .advice = "lower b.size"};
  };
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(log_, HasSubstr("warning: b: needs about 1152922 TB of memory"));
  EXPECT_THAT(log_, HasSubstr("but only "));
  EXPECT_THAT(log_, HasSubstr(". To need less, lower b.size\n"));
  EXPECT_EQ(Runs(), "111");
}

TEST_F(StageRunnerTest, AnUnknownNeedOfMemoryIsNoFault) {
  b_.need = [](const StageContext&) -> StageNeed {
    throw std::runtime_error("odd file");
  };
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(log_, Not(HasSubstr("needs about")));
}

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

TEST_F(StageRunnerTest, StageNameIsNotRepeated) {
  b_.act = [](StageContext& context) {
    context.log(LogLevel::kInfo, "b: one");
    context.log(LogLevel::kInfo, "two");
    return UnusableResultError("b: no");
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
  EXPECT_EQ(Run().code(), StatusCode::kInterrupted);
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

TEST_F(StageRunnerTest, KilledStageIsContinued) {
  KillDuringB();
  EXPECT_TRUE(fs::exists(workspace() / "b.partial" / "checkpoint"));
  EXPECT_TRUE(fs::exists(workspace() / "b.partial" / "usage.json"));
  ASSERT_TRUE(Run().ok());
  EXPECT_TRUE(b_.resumed);
  EXPECT_GT(b_.earlier_seconds, 0);
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
