// SPDX-License-Identifier: BSD-3-Clause

#include "stages/run/psnr_run.h"

#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

using pipeline::LogLevel;
using pipeline::OptionSetting;

// A scene that 5000 iterations take to `best` dB, and half of the iterations to
// `gain` dB less; or one whose dB after so many iterations are `measured`.
class FakeScene {
 public:
  FakeScene(double best, double gain) : best_(best), gain_(gain) {}
  explicit FakeScene(std::map<int, double> measured)
      : measured_(std::move(measured)) {}

  PsnrRunTasks Tasks() {
    PsnrRunTasks tasks;
    tasks.look = [this](const std::vector<OptionSetting>& settings) {
      const int iterations = Iterations(settings);
      TrainingState state;
      if (iterations == there_) state.psnr = PsnrAfter(iterations);
      state.begun = iterations == begun_;
      return StatusOr<TrainingState>(state);
    };
    tasks.train =
        [this](const std::vector<OptionSetting>& settings) -> StatusOr<double> {
      const int iterations = Iterations(settings);
      trained_.push_back(iterations);
      if (iterations == interrupted_) {
        begun_ = std::exchange(interrupted_, 0);
        return InterruptedError("stopped");
      }
      there_ = iterations;
      begun_ = 0;
      return PsnrAfter(there_);
    };
    tasks.finish = [this](const std::vector<OptionSetting>& settings) {
      finished_ = Iterations(settings);
      return Status();
    };
    tasks.log = [this](LogLevel level, const std::string& text) {
      warnings_ += level == LogLevel::kWarning;
      log_ += text + "\n";
    };
    return tasks;
  }

  // The next training of so many iterations is interrupted.
  void Interrupt(int iterations) { interrupted_ = iterations; }

  const std::vector<int>& trained() const { return trained_; }
  int finished() const { return finished_; }
  int warnings() const { return warnings_; }
  const std::string& log() const { return log_; }

 private:
  static int Iterations(const std::vector<OptionSetting>& settings) {
    for (const OptionSetting& setting : settings) {
      if (setting.name == "reconstruct.iterations") {
        return std::atoi(setting.value.c_str());
      }
    }
    ADD_FAILURE();
    return 0;
  }

  double PsnrAfter(int iterations) const {
    if (!measured_.empty()) return measured_.at(iterations);
    return best_ - gain_ * std::log2(5000.0 / iterations);
  }

  const double best_ = 0;
  const double gain_ = 0;
  const std::map<int, double> measured_;
  int there_ = 0;  // The iterations of the scene that the workspace has.
  int interrupted_ = 0;
  int begun_ = 0;  // The iterations of the training that was interrupted.
  std::vector<int> trained_;
  int finished_ = 0;
  int warnings_ = 0;
  std::string log_;
};

TEST(PsnrRun, ReadsGoals) {
  EXPECT_EQ(*ParsePsnrGoal("psnr=27"), 27);
  EXPECT_EQ(*ParsePsnrGoal("psnr=27.5"), 27.5);
  for (const char* text : {"",
                           "27",
                           "psnr",
                           "psnr=",
                           "psnr=x",
                           "psnr=27x",
                           "psnr=-3",
                           "psnr=0",
                           "psnr=101",
                           "psnr=nan",
                           "psnr=inf",
                           "ssim=0.9"}) {
    EXPECT_EQ(ParsePsnrGoal(text).status().code(), StatusCode::kInvalidArgument)
        << text;
  }
}

TEST(PsnrRun, StopsWhereAShortTrainingIsEnough) {
  FakeScene scene(30, 1);
  ASSERT_TRUE(RunAtLeast(26, scene.Tasks()).ok());
  EXPECT_EQ(scene.trained().size(), 1u);
  EXPECT_EQ(scene.finished(), scene.trained().back());
  EXPECT_EQ(scene.warnings(), 0) << scene.log();
}

TEST(PsnrRun, TrainsLongerUntilItIsEnough) {
  FakeScene scene(30, 1);
  ASSERT_TRUE(RunAtLeast(28.5, scene.Tasks()).ok());
  EXPECT_EQ(scene.finished(), 2500) << scene.log();
  EXPECT_EQ(scene.warnings(), 0) << scene.log();
  double all = 0;
  for (const int iterations : scene.trained()) all += iterations;
  EXPECT_LE(all, 2 * scene.finished());
}

TEST(PsnrRun, LeavesOutTrainingsThatWillNotBeEnough) {
  FakeScene scene(30, 1);
  ASSERT_TRUE(RunAtLeast(28.8, scene.Tasks()).ok());
  EXPECT_EQ(scene.trained().size(), 2u) << scene.log();
  EXPECT_EQ(scene.finished(), 5000) << scene.log();
}

TEST(PsnrRun, BeginsWithTheTrainingThatIsThere) {
  FakeScene scene(30, 1);
  ASSERT_TRUE(RunAtLeast(28.5, scene.Tasks()).ok());
  const std::vector<int> trained = scene.trained();
  ASSERT_TRUE(RunAtLeast(28.5, scene.Tasks()).ok());
  EXPECT_EQ(scene.trained(), trained);
  EXPECT_EQ(scene.finished(), 2500) << scene.log();
  // More is asked for: no training is done twice.
  ASSERT_TRUE(RunAtLeast(30, scene.Tasks()).ok());
  EXPECT_EQ(scene.trained().back(), 5000) << scene.log();
  EXPECT_EQ(scene.trained().size(), trained.size() + 1);
}

// After two trainings the run has chosen 5000 iterations. From the second one
// alone it would choose 2500.
TEST(PsnrRun, GoesOnWithTheTrainingThatWasInterrupted) {
  FakeScene scene(28.3, 0.4);
  scene.Interrupt(5000);
  EXPECT_EQ(RunAtLeast(28.05, scene.Tasks()).code(), StatusCode::kInterrupted);
  ASSERT_EQ(scene.trained(), (std::vector<int>{625, 1250, 5000}))
      << scene.log();
  ASSERT_TRUE(RunAtLeast(28.05, scene.Tasks()).ok());
  EXPECT_EQ(scene.trained(), (std::vector<int>{625, 1250, 5000, 5000}))
      << scene.log();
  EXPECT_EQ(scene.finished(), 5000);
  // A lower goal needs no more than what is done.
  FakeScene other(30, 1);
  other.Interrupt(5000);
  EXPECT_EQ(RunAtLeast(35, other.Tasks()).code(), StatusCode::kInterrupted);
  ASSERT_TRUE(RunAtLeast(26, other.Tasks()).ok());
  EXPECT_EQ(other.finished(), 625) << other.log();
}

// One training tells too little to give up.
TEST(PsnrRun, TriesTheLongestWhereItIsNotFarFromEnough) {
  FakeScene scene(30, 1);
  ASSERT_TRUE(RunAtLeast(35, scene.Tasks()).ok());
  EXPECT_EQ(scene.trained(), (std::vector<int>{625, 5000}));
  EXPECT_EQ(scene.finished(), 5000);
  EXPECT_EQ(scene.warnings(), 1) << scene.log();
}

// More iterations make this scene worse.
TEST(PsnrRun, GivesUpWhereTrainingDoesNotHelp) {
  FakeScene scene(30, -1);
  ASSERT_TRUE(RunAtLeast(33.9, scene.Tasks()).ok());
  EXPECT_EQ(scene.trained(), (std::vector<int>{625, 1250}));
  EXPECT_EQ(scene.finished(), 1250);
  EXPECT_EQ(scene.warnings(), 2) << scene.log();
  EXPECT_NE(scene.log().find("not worth trying"), std::string::npos)
      << scene.log();
}

TEST(PsnrRun, WhatIsBarelyMissedDoesNotLookReached) {
  FakeScene scene({{625, 26.96}, {1250, 26.96}, {2500, 26.96}, {5000, 26.96}});
  ASSERT_TRUE(RunAtLeast(27, scene.Tasks()).ok());
  EXPECT_GE(scene.warnings(), 1);
  EXPECT_NE(scene.log().find("have only 26.96 dB"), std::string::npos)
      << scene.log();
  EXPECT_NE(scene.log().find("gave 26.96 dB"), std::string::npos);
  EXPECT_EQ(scene.log().find("gave 27.0 dB"), std::string::npos) << scene.log();
}

// Fox, as docs/speed_accuracy.md has it under "At least so accurate".
TEST(PsnrRun, OnFoxItDependsOnWhereItBeginsWhetherItGivesUp) {
  const std::map<int, double> fox = {
      {625, 29.9}, {1250, 31.2}, {2500, 31.1}, {5000, 32.1}};
  FakeScene scene(fox);
  ASSERT_TRUE(RunAtLeast(32, scene.Tasks()).ok());
  EXPECT_EQ(scene.trained(), (std::vector<int>{625, 5000})) << scene.log();
  EXPECT_EQ(scene.finished(), 5000);
  EXPECT_EQ(scene.warnings(), 0) << scene.log();
  FakeScene other(fox);
  ASSERT_TRUE(RunAtLeast(30.5, other.Tasks()).ok());
  EXPECT_EQ(other.finished(), 1250) << other.log();
  ASSERT_TRUE(RunAtLeast(31.8, other.Tasks()).ok());
  EXPECT_EQ(other.trained(), (std::vector<int>{625, 1250, 2500}))
      << other.log();
  EXPECT_EQ(other.finished(), 2500);
  EXPECT_EQ(other.warnings(), 2) << other.log();
}

TEST(PsnrRun, ReturnsErrors) {
  FakeScene scene(30, 1);
  PsnrRunTasks tasks = scene.Tasks();
  tasks.finish = [](const auto&) { return InterruptedError("stopped"); };
  EXPECT_EQ(RunAtLeast(20, tasks).code(), StatusCode::kInterrupted);
  FakeScene other(30, 1);
  tasks = other.Tasks();
  tasks.train = [](const auto&) -> StatusOr<double> {
    return BadInputError("no photos were kept");
  };
  EXPECT_EQ(RunAtLeast(20, tasks).code(), StatusCode::kBadInput);
}

}  // namespace
}  // namespace freegs::stages
