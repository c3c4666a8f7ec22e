// SPDX-License-Identifier: BSD-3-Clause

#include "splat/train/training_schedule.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace freegs::splat {
namespace {

ScheduleOptions Options(
    int iterations,
    DensificationMethod method = DensificationMethod::kMiniSplatting) {
  ScheduleOptions options;
  options.iterations = iterations;
  options.method = method;
  return options;
}

TEST(TrainingSchedule, TheScheduleOfThePaper) {
  ScheduleOptions options = Options(30000);
  options.sh_start = 0.5;
  const TrainingSchedule schedule(options);
  EXPECT_EQ(schedule.Describe(),
            "depth_reinitialization 5000, depth_reinitialization 10000, "
            "simplification 15000, pruning 20000");
  EXPECT_FALSE(schedule.Densifies(400));
  EXPECT_TRUE(schedule.Densifies(500));
  EXPECT_FALSE(schedule.Densifies(550));
  EXPECT_FALSE(schedule.Densifies(5000));  // Starts again instead.
  EXPECT_TRUE(schedule.Densifies(14900));
  EXPECT_FALSE(schedule.Densifies(15000));
  EXPECT_FALSE(schedule.Densifies(15100));
  EXPECT_EQ(schedule.ShDegree(14999), 0);
  EXPECT_EQ(schedule.ShDegree(15999), 0);
  EXPECT_EQ(schedule.ShDegree(16000), 1);
  EXPECT_EQ(schedule.ShDegree(17000), 2);
  EXPECT_EQ(schedule.ShDegree(29999), 3);
  EXPECT_EQ(schedule.PositionRateIteration(14999), 14999);
  EXPECT_EQ(schedule.PositionRateIteration(15000), 5000);
  EXPECT_EQ(schedule.PositionRateIteration(29999), 19999);
}

TEST(TrainingSchedule, ShDegreesCountFromTheirStart) {
  for (const DensificationMethod method :
       {DensificationMethod::kNone,
        DensificationMethod::kGradient,
        DensificationMethod::kMiniSplatting}) {
    for (const int start : {0, 300, 1500, 3000}) {
      ScheduleOptions options = Options(3000, method);
      options.sh_start = start / 3000.0;
      ASSERT_TRUE(options.Check().ok());
      const TrainingSchedule schedule(options);
      for (const int after : {0, 50, 150, 250, 350, 1450}) {
        EXPECT_EQ(schedule.ShDegree(start + after), std::min(3, after / 100))
            << start << " " << after;
      }
      for (const int before : {1, 50, 150}) {
        EXPECT_EQ(schedule.ShDegree(start - before), 0) << start;
      }
      options.sh_degree = 1;
      EXPECT_EQ(TrainingSchedule(options).ShDegree(start + 1450), 1);
      options.sh_degree_interval = 0;
      EXPECT_EQ(TrainingSchedule(options).ShDegree(start - 1), 0);
      EXPECT_EQ(TrainingSchedule(options).ShDegree(start), 1);
    }
  }
}

TEST(TrainingSchedule, MilestonesScaleAndTooShortOnesDrop) {
  EXPECT_EQ(TrainingSchedule(Options(5000)).Describe(),
            "depth_reinitialization 833, depth_reinitialization 1667, "
            "simplification 2500, pruning 3333");
  EXPECT_EQ(TrainingSchedule(Options(100)).Describe(),
            "depth_reinitialization 17, depth_reinitialization 33, "
            "simplification 50, pruning 67");
  EXPECT_EQ(TrainingSchedule(Options(40)).Describe(),
            "simplification 20");  // 7, 13 and 27 come too soon.
  EXPECT_EQ(TrainingSchedule(Options(10)).Describe(), "simplification 5");
  EXPECT_EQ(TrainingSchedule(Options(1)).Describe(), "simplification 1");
}

TEST(TrainingSchedule, MilestonesAreDistinctAndOrderedForAnyOptions) {
  for (int iterations = 1; iterations < 400; ++iterations) {
    for (const double simplify : {0.0, 0.02, 0.5, 0.97, 1.0}) {
      for (const double prune : {0.0, 0.5, 2.0 / 3, 0.99, 1.0, 7.0}) {
        ScheduleOptions options = Options(iterations);
        options.depth_reinit_at = {0, 0, 0.1, 0.1001, 0.3, 0.5, 0.9, 1};
        options.simplify_at = simplify;
        options.prune_at = prune;
        ASSERT_TRUE(options.Check().ok());
        const TrainingSchedule schedule(options);
        int64_t last = 0;
        int simplifications = 0;
        for (const Milestone& milestone : schedule.milestones()) {
          ASSERT_GT(milestone.iteration, last) << schedule.Describe();
          ASSERT_LE(milestone.iteration, iterations) << schedule.Describe();
          ASSERT_EQ(schedule.MilestoneAt(milestone.iteration), milestone.event);
          last = milestone.iteration;
          simplifications += milestone.event == TrainingEvent::kSimplification;
        }
        ASSERT_EQ(simplifications, 1) << schedule.Describe();
      }
    }
  }
}

// Statistics are collected by exactly those steps that some densification
// reads: after the densification or milestone before it.
TEST(TrainingSchedule, StatisticsAreCollectedWhereTheyAreRead) {
  for (const DensificationMethod method :
       {DensificationMethod::kNone,
        DensificationMethod::kGradient,
        DensificationMethod::kMiniSplatting}) {
    for (const int iterations : {1, 10, 100, 130, 600, 1234}) {
      for (const int interval : {0, 1, 20, 100}) {
        ScheduleOptions options = Options(iterations, method);
        options.densify_interval = interval;
        const TrainingSchedule schedule(options);
        bool read = false;
        for (int64_t done = iterations; done-- > 0;) {
          if (schedule.Densifies(done + 1)) read = true;
          if (schedule.MilestoneAt(done + 1)) read = false;
          ASSERT_EQ(schedule.CollectsStatistics(done), read)
              << static_cast<int>(method) << " " << iterations << " "
              << interval << " " << done;
        }
      }
    }
  }
}

TEST(TrainingSchedule, GradientMethod) {
  const TrainingSchedule schedule(
      Options(1000, DensificationMethod::kGradient));
  EXPECT_TRUE(schedule.milestones().empty());
  EXPECT_EQ(schedule.Describe(), "none");
  EXPECT_TRUE(schedule.Densifies(100));
  EXPECT_TRUE(schedule.Densifies(400));
  EXPECT_FALSE(schedule.Densifies(500));
  EXPECT_EQ(schedule.ShDegree(0), 0);
  EXPECT_EQ(schedule.ShDegree(34), 1);
  EXPECT_EQ(schedule.PositionRateIteration(900), 900);
}

TEST(TrainingSchedule, NoDensification) {
  const TrainingSchedule schedule(Options(1000, DensificationMethod::kNone));
  for (int64_t done = 0; done <= 1000; ++done) {
    EXPECT_FALSE(schedule.CollectsStatistics(done));
    EXPECT_FALSE(schedule.MilestoneAt(done).has_value());
    EXPECT_FALSE(schedule.Densifies(done));
  }
}

TEST(TrainingSchedule, ResolutionLevels) {
  const TrainingSchedule schedule(Options(100));
  EXPECT_EQ(schedule.ResolutionLevel(0, 3), 2);
  EXPECT_EQ(schedule.ResolutionLevel(9, 3), 2);
  EXPECT_EQ(schedule.ResolutionLevel(10, 3), 1);
  EXPECT_EQ(schedule.ResolutionLevel(30, 3), 0);
  EXPECT_EQ(schedule.ResolutionLevel(0, 2), 1);
  EXPECT_EQ(schedule.ResolutionLevel(0, 1), 0);
}

TEST(TrainingSchedule, EndsAtTheFinestLevel) {
  ScheduleOptions options = Options(100);
  options.finest_level = 1;
  ASSERT_TRUE(options.Check().ok());
  const TrainingSchedule schedule(options);
  EXPECT_EQ(schedule.ResolutionLevel(0, 5), 3);
  EXPECT_EQ(schedule.ResolutionLevel(10, 5), 2);
  EXPECT_EQ(schedule.ResolutionLevel(30, 5), 1);
  EXPECT_EQ(schedule.ResolutionLevel(99, 5), 1);
  // No coarser than there are images.
  EXPECT_EQ(schedule.ResolutionLevel(0, 2), 1);
  EXPECT_EQ(schedule.ResolutionLevel(99, 1), 0);
  options.resolution_steps.clear();
  EXPECT_EQ(TrainingSchedule(options).ResolutionLevel(0, 5), 1);
}

TEST(ScheduleOptions, CheckRefusesValuesOutOfRange) {
  EXPECT_TRUE(ScheduleOptions().Check().ok());
  ScheduleOptions options;
  options.depth_reinit_at = {0.4, 0.2};
  EXPECT_FALSE(options.Check().ok());
  options = ScheduleOptions();
  options.depth_reinit_at = {-0.1};
  EXPECT_FALSE(options.Check().ok());
  options = ScheduleOptions();
  options.simplify_at = 1.5;
  EXPECT_FALSE(options.Check().ok());
  options = ScheduleOptions();
  options.prune_at = -1;
  EXPECT_FALSE(options.Check().ok());
  options = ScheduleOptions();
  options.finest_level = -1;
  EXPECT_FALSE(options.Check().ok());
  for (const double start : {-0.1, 1.1, std::nan("")}) {
    options = ScheduleOptions();
    options.sh_start = start;
    EXPECT_FALSE(options.Check().ok()) << start;
  }
}

}  // namespace
}  // namespace freegs::splat
