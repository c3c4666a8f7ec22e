// SPDX-License-Identifier: BSD-3-Clause
// What the runner says before and while stages need memory and time.

#include <chrono>
#include <filesystem>
#include <optional>
#include <sstream>
#include <stdexcept>
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

TEST_F(StageRunnerTest, TellsThatNothingIsKnown) {
  to_ = "b";
  ASSERT_TRUE(Run().ok());
  EXPECT_TRUE(log_.starts_with("run: nothing is known of a, b\n")) << log_;
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

// The deadline of the forced stage leaves them their time.
TEST_F(StageRunnerTest, ForecastsThatStagesAfterAForcedOneAreRedone) {
  const auto takes = [](double seconds) {
    return [seconds](const StageContext&) {
      return StageNeed{.memory_bytes = 1000, .seconds = seconds};
    };
  };
  a_.need = takes(10);
  b_.need = takes(20);
  c_.need = takes(30);
  ASSERT_TRUE(Run().ok());
  const auto forecast = [this] {
    std::ostringstream console;
    Logger logger(console, /*terminal=*/false, "");
    return *MakeRunner(&logger).Forecast();
  };
  EXPECT_FALSE(forecast()[2].needed);
  forced_ = "a";
  std::vector<StageForecast> stages = forecast();
  EXPECT_EQ(stages[0].reason, "redone as asked");
  EXPECT_TRUE(stages[0].needed && stages[1].needed && stages[2].needed);
  EXPECT_EQ(stages[1].reason, "stage a is redone");
  EXPECT_EQ(stages[2].reason, "stage a is redone");
  EXPECT_FALSE(stages[2].need.from_files);

  deadline_ = std::chrono::steady_clock::now() + std::chrono::hours(1);
  std::optional<std::chrono::steady_clock::time_point> deadline_of_a;
  a_.act = [&deadline_of_a](StageContext& context) {
    deadline_of_a = context.deadline;
    return Status();
  };
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(Runs(), "222");
  EXPECT_THAT(log_, HasSubstr("run: expected to take about 1 min"));
  ASSERT_TRUE(deadline_of_a.has_value());
  EXPECT_EQ(*deadline_ - *deadline_of_a, std::chrono::seconds(50));

  // Only stages of the run are done again, and results of others never.
  to_ = "b";
  stages = forecast();
  EXPECT_TRUE(stages[1].needed);
  EXPECT_FALSE(stages[2].needed);
  to_ = "";
  forced_ = "b";
  stages = forecast();
  EXPECT_FALSE(stages[0].needed);
  EXPECT_EQ(stages[2].reason, "stage b is redone");
  from_ = "c";
  EXPECT_FALSE(forecast()[2].needed);
  from_ = "";
  fs::remove(workspace() / "c" / "stage.json");
  stages = forecast();
  EXPECT_TRUE(stages[1].needed);
  EXPECT_FALSE(stages[2].needed);
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

}  // namespace
}  // namespace freegs::pipeline
