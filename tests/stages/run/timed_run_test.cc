// SPDX-License-Identifier: BSD-3-Clause

#include "stages/run/timed_run.h"

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

using pipeline::LogLevel;
using pipeline::OptionSetting;

double Value(const std::vector<OptionSetting>& settings,
             const std::string& name) {
  for (const OptionSetting& setting : settings) {
    if (setting.name == name) {
      return std::strtod(setting.value.c_str(), nullptr);
    }
  }
  ADD_FAILURE() << name;
  return 0;
}

// A machine that is `slower` than foretold.
class FakeMachine {
 public:
  explicit FakeMachine(double slower) : slower_(slower) {}

  TimedRunTasks Tasks() {
    TimedRunTasks tasks;
    tasks.now = [this] { return now_; };
    tasks.foretell = [this](const std::vector<OptionSetting>& settings) {
      return StatusOr<ExpectedRun>(Expected(settings));
    };
    tasks.run = [this](const std::vector<OptionSetting>& settings,
                       RunPart part,
                       double end) {
      const ExpectedRun expected = Expected(settings);
      if (part == RunPart::kCameras) {
        now_ += slower_ * expected.cameras;
        cameras_done_ = true;
      } else {
        // Training stops where the time is up that it has by the forecasts.
        const double training = expected.others - expected.after_training;
        now_ +=
            std::min(slower_ * training, end - expected.after_training - now_);
        now_ += slower_ * expected.after_training;
      }
      runs_.push_back(settings);
      return Status();
    };
    tasks.log = [this](LogLevel level, const std::string& text) {
      warnings_ += level == LogLevel::kWarning;
      log_ += text + "\n";
    };
    return tasks;
  }

  double took() const { return now_ - kBegin; }
  int warnings() const { return warnings_; }
  const std::string& log() const { return log_; }
  const std::vector<std::vector<OptionSetting>>& runs() const { return runs_; }

 private:
  static constexpr double kBegin = 1000;

  ExpectedRun Expected(const std::vector<OptionSetting>& settings) const {
    const double side = Value(settings, "reconstruct.max_image_size");
    return {.cameras =
                cameras_done_ ? 0 : 0.01 * Value(settings, "sfm.max_features"),
            .others = 10 + 4e-8 * side * side *
                               Value(settings, "reconstruct.iterations"),
            .after_training = 10};
  }

  const double slower_;
  double now_ = kBegin;
  bool cameras_done_ = false;
  int warnings_ = 0;
  std::string log_;
  std::vector<std::vector<OptionSetting>> runs_;
};

TEST(TimedRun, KeepsToTheTimeWhereForecastsAreRight) {
  for (const double seconds : {60.0, 120.0, 300.0}) {
    FakeMachine machine(1);
    ASSERT_TRUE(RunWithin(seconds, machine.Tasks()).ok());
    EXPECT_LE(machine.took(), seconds);
    EXPECT_GE(machine.took(), 0.85 * seconds);
    EXPECT_EQ(machine.warnings(), 0) << machine.log();
  }
}

TEST(TimedRun, TrainsLessWhereTheCamerasTookLong) {
  FakeMachine right(1), slow(1.8);
  ASSERT_TRUE(RunWithin(200, right.Tasks()).ok());
  ASSERT_TRUE(RunWithin(200, slow.Tasks()).ok());
  EXPECT_LE(slow.took(), 200);
  ASSERT_EQ(slow.runs().size(), 2u);
  EXPECT_LT(Value(slow.runs()[1], "reconstruct.iterations"),
            Value(right.runs()[1], "reconstruct.iterations"));
  // The cameras are not found anew.
  EXPECT_EQ(Value(slow.runs()[1], "sfm.max_features"),
            Value(slow.runs()[0], "sfm.max_features"));
}

TEST(TimedRun, TrainsMoreOnAFastMachine) {
  FakeMachine right(1), fast(0.5);
  ASSERT_TRUE(RunWithin(120, right.Tasks()).ok());
  ASSERT_TRUE(RunWithin(120, fast.Tasks()).ok());
  EXPECT_GT(Value(fast.runs()[1], "reconstruct.iterations"),
            Value(right.runs()[1], "reconstruct.iterations"));
}

// The cameras are there soon because an interrupted run left a part of them.
TEST(TimedRun, NotEveryTimeOfTheCamerasTellsThePace) {
  FakeMachine fast(0.5), resumed(0.5);
  TimedRunTasks tasks = resumed.Tasks();
  tasks.foretell = [known = tasks.foretell](const auto& settings) {
    StatusOr<ExpectedRun> expected = known(settings);
    expected->cameras_tell_pace = false;
    return expected;
  };
  ASSERT_TRUE(RunWithin(120, fast.Tasks()).ok());
  ASSERT_TRUE(RunWithin(120, tasks).ok());
  EXPECT_LT(Value(resumed.runs()[1], "reconstruct.iterations"),
            Value(fast.runs()[1], "reconstruct.iterations"));
}

// Nothing is foretold of a film until there are pictures of it.
TEST(TimedRun, TakesThePicturesOfAFilmBeforeItChooses) {
  FakeMachine machine(1);
  TimedRunTasks tasks = machine.Tasks();
  std::vector<RunPart> parts;
  tasks.foretell = [&, known = tasks.foretell](const auto& settings) {
    return parts.empty() ? StatusOr<ExpectedRun>(ExpectedRun())
                         : known(settings);
  };
  tasks.run = [&, run = tasks.run](
                  const auto& settings, RunPart part, double end) {
    parts.push_back(part);
    return part == RunPart::kPhotos ? Status() : run(settings, part, end);
  };
  ASSERT_TRUE(RunWithin(60, tasks).ok());
  EXPECT_EQ(parts,
            (std::vector{RunPart::kPhotos, RunPart::kCameras, RunPart::kAll}));
  EXPECT_LE(machine.took(), 60);
  EXPECT_EQ(machine.warnings(), 0) << machine.log();
}

TEST(TimedRun, WarnsWhereTheTimeIsTooShort) {
  FakeMachine machine(1);
  ASSERT_TRUE(RunWithin(5, machine.Tasks()).ok());
  EXPECT_GE(machine.warnings(), 1);
  EXPECT_NE(machine.log().find("nothing shorter"), std::string::npos)
      << machine.log();
}

TEST(TimedRun, ReturnsErrors) {
  FakeMachine machine(1);
  TimedRunTasks tasks = machine.Tasks();
  tasks.run = [](const auto&, RunPart, double) {
    return InterruptedError("stopped");
  };
  EXPECT_EQ(RunWithin(100, tasks).code(), StatusCode::kInterrupted);
}

}  // namespace
}  // namespace freegs::stages
