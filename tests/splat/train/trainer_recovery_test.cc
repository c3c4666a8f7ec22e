// SPDX-License-Identifier: BSD-3-Clause
// Training that diverges goes back, says so, and stays reproducible. Training
// that is stopped in a milestone goes on from there.

#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "splat/train/trainer.h"
#include "tests/splat/training_fixture.h"

namespace freegs::splat {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using TrainerRecoveryTest = TrainingFixture;

// A rate of colour at which the loss explodes once or more, but not once the
// rate has been halved often enough.
TrainerOptions Wild(TrainerOptions options) {
  options.snapshot_interval = 10;
  options.learning_rates.sh_dc = 200;
  return options;
}

TEST_F(TrainerRecoveryTest, GoesBackFromAnExplodingLoss) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  for (const DensificationMethod method :
       {DensificationMethod::kGradient, DensificationMethod::kMiniSplatting}) {
    Trainer trainer(Wild(Options(120, method)), Start(), 2.0, &images, pool);
    int64_t before = 0;
    size_t seen = 0;
    while (!trainer.done()) {
      const StatusOr<StepReport> report = trainer.Step();
      ASSERT_TRUE(report.ok()) << report.status().message();
      EXPECT_EQ(report->iteration, trainer.iteration());
      if (report->recovered) {
        ++seen;
        const Recovery& recovery = trainer.recoveries().back();
        EXPECT_EQ(recovery.iteration, before + 1);
        EXPECT_EQ(recovery.back_to, report->iteration);
        EXPECT_LE(recovery.back_to, recovery.iteration);
        EXPECT_EQ(recovery.rate_factor, std::pow(0.5, seen));
        EXPECT_THAT(recovery.reason, HasSubstr("the loss rose to"));
      }
      before = report->iteration;
    }
    EXPECT_GE(seen, 1u);
    EXPECT_EQ(trainer.recoveries().size(), seen);
    EXPECT_TRUE(trainer.model().AllFinite());
  }
}

TEST_F(TrainerRecoveryTest, SameBytesAcrossARestoreAndForAnyNumberOfThreads) {
  for (const DensificationMethod method :
       {DensificationMethod::kGradient, DensificationMethod::kMiniSplatting}) {
    const TrainerOptions options = Wild(Options(120, method));
    std::string end;
    std::vector<std::string> saved;  // After every step, repeats included.
    for (const int threads : {1, 2, 3, 5}) {
      ThreadPool pool(threads);
      TrainingImages images = Images(pool);
      Trainer trainer(options, Start(), 2.0, &images, pool);
      while (!trainer.done()) {
        ASSERT_TRUE(trainer.Step().ok());
        if (threads == 1) saved.push_back(SerializeCheckpoint(trainer.Save()));
      }
      ASSERT_FALSE(trainer.recoveries().empty());
      if (end.empty()) end = SerializeCheckpoint(trainer.Save());
      EXPECT_EQ(SerializeCheckpoint(trainer.Save()), end) << threads;
    }
    ThreadPool pool(2);
    TrainingImages images = Images(pool);
    for (size_t k = 0; k < saved.size(); k += 7) {
      StatusOr<TrainingCheckpoint> checkpoint = ParseCheckpoint(saved[k]);
      ASSERT_TRUE(checkpoint.ok());
      Trainer trainer(options, Start(), 2.0, &images, pool);
      ASSERT_TRUE(trainer.Restore(std::move(checkpoint).value()).ok());
      ASSERT_TRUE(Finish(&trainer).ok());
      EXPECT_EQ(SerializeCheckpoint(trainer.Save()), end) << "step " << k;
    }
  }
}

TEST_F(TrainerRecoveryTest, GoesBackFromNumbersThatAreNotFinite) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  TrainerOptions options = Options(120, DensificationMethod::kMiniSplatting);
  options.snapshot_interval = 25;
  for (const Parameter parameter : kAllParameters) {
    for (const int64_t stop : {30, 59, 70}) {  // 60 simplifies.
      Trainer trainer(options, Start(), 2.0, &images, pool);
      while (trainer.iteration() < stop) ASSERT_TRUE(trainer.Step().ok());
      TrainingCheckpoint checkpoint = trainer.Save();
      std::vector<float>& array = ParameterArray(checkpoint.model, parameter);
      if (array.empty()) continue;  // No coefficients of degree 1 yet.
      for (float& value : array) {
        value = std::numeric_limits<float>::quiet_NaN();
      }
      ASSERT_TRUE(trainer.Restore(std::move(checkpoint)).ok());
      const Status status = Finish(&trainer);
      ASSERT_TRUE(status.ok()) << status.message();
      EXPECT_EQ(trainer.recoveries().size(), 1u);
      EXPECT_EQ(trainer.recoveries()[0].back_to,
                stop < 60 ? stop - stop % 25 : 60);
      EXPECT_TRUE(trainer.model().AllFinite());
      // No milestone twice.
      EXPECT_EQ(trainer.milestones().size(), 4u);
    }
  }
}

// Between the steps that test all numbers, a colour that is not finite has not
// been noticed yet.
TEST_F(TrainerRecoveryTest, GoesBackWhereATrainingIsEnded) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  TrainerOptions options = Options(120, DensificationMethod::kMiniSplatting);
  options.snapshot_interval = 25;
  Trainer trainer(options, Start(), 2.0, &images, pool);
  while (trainer.iteration() < 30) ASSERT_TRUE(trainer.Step().ok());
  EXPECT_EQ(trainer.GoBackUnlessFinite().value(), false);
  EXPECT_EQ(trainer.iteration(), 30);
  TrainingCheckpoint checkpoint = trainer.Save();
  checkpoint.model.sh_dc.back() = std::numeric_limits<float>::quiet_NaN();
  ASSERT_TRUE(trainer.Restore(std::move(checkpoint)).ok());
  EXPECT_EQ(trainer.GoBackUnlessFinite().value(), true);
  EXPECT_EQ(trainer.iteration(), 25);
  EXPECT_TRUE(trainer.model().AllFinite());
  ASSERT_EQ(trainer.recoveries().size(), 1u);
  EXPECT_EQ(trainer.recoveries()[0].iteration, 30);
  EXPECT_EQ(trainer.GoBackUnlessFinite().value(), false);
}

TEST_F(TrainerRecoveryTest, TheColoursOfPhotosGoBackToo) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  TrainerOptions options = Options(120, DensificationMethod::kMiniSplatting);
  options.snapshot_interval = 25;
  options.exposure.learn = true;
  Trainer trainer(options, Start(), 2.0, &images, pool);
  while (trainer.iteration() < 40) ASSERT_TRUE(trainer.Step().ok());
  TrainingCheckpoint checkpoint = trainer.Save();
  for (PhotoColors::Entry& entry : checkpoint.history.colors.entries) {
    entry.color.values.fill(std::numeric_limits<float>::quiet_NaN());
  }
  ASSERT_TRUE(trainer.Restore(std::move(checkpoint)).ok());
  const Status status = Finish(&trainer);
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(trainer.recoveries().size(), 1u);
  for (const PhotoExposure& exposure : trainer.Exposures()) {
    for (const float value : exposure.color.values) {
      EXPECT_TRUE(std::isfinite(value));
    }
  }
}

TEST_F(TrainerRecoveryTest, GivesUpInTheEnd) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  for (const DensificationMethod method :
       {DensificationMethod::kGradient, DensificationMethod::kMiniSplatting}) {
    TrainerOptions options = Options(120, method);
    options.learning_rates.sh_dc = 1e6;
    Trainer trainer(options, Start(), 2.0, &images, pool);
    const Status status = Finish(&trainer);
    EXPECT_EQ(status.code(), StatusCode::kUnusableResult);
    EXPECT_THAT(status.message(), HasSubstr("training diverged at iteration"));
    EXPECT_THAT(status.message(), HasSubstr("learning rates; check the"));
    // There is no option to lower them.
    EXPECT_THAT(status.message(), Not(HasSubstr("lower the")));
    EXPECT_EQ(trainer.recoveries().size(), 5u);
  }
}

// Every rate absurd: whatever happens, it ends with finite numbers or with a
// reason.
TEST_F(TrainerRecoveryTest, AbsurdRatesOfAnyParameter) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  for (const DensificationMethod method :
       {DensificationMethod::kGradient, DensificationMethod::kMiniSplatting}) {
    for (int which = 0; which < 5; ++which) {
      for (const double rate : {10.0, 1e5, 1e30}) {
        TrainerOptions options = Options(60, method);
        LearningRateOptions& rates = options.learning_rates;
        double* const all[] = {&rates.mean_initial,
                               &rates.log_scale,
                               &rates.rotation,
                               &rates.opacity_logit,
                               &rates.sh_rest};
        *all[which] = rate;
        Trainer trainer(options, Start(), 2.0, &images, pool);
        const Status status = Finish(&trainer);
        if (status.ok()) {
          EXPECT_TRUE(trainer.model().AllFinite()) << which << " " << rate;
        } else {
          EXPECT_EQ(status.code(), StatusCode::kUnusableResult);
          EXPECT_FALSE(status.message().empty());
        }
      }
    }
  }
}

TEST_F(TrainerRecoveryTest, SameBytesAfterMilestonesThatWereStopped) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  CancellationToken cancelled;
  cancelled.Cancel();
  TrainerOptions options = NearPaperOptions(120);
  options.exposure.learn = true;
  Trainer whole(options, Start(), 2.0, &images, pool);
  ASSERT_TRUE(Finish(&whole).ok());
  std::optional<Trainer> trainer;
  trainer.emplace(options, Start(), 2.0, &images, pool);
  int stopped = 0;
  while (!trainer->done()) {
    const StatusOr<StepReport> report = trainer->Step(&cancelled);
    ASSERT_TRUE(report.ok()) << report.status().message();
    if (!report->interrupted) continue;
    EXPECT_EQ(trainer->FinishMilestone(&cancelled).status().code(),
              StatusCode::kInterrupted);
    EXPECT_EQ(trainer->Step(&cancelled).status().code(),
              StatusCode::kInterrupted);
    StatusOr<TrainingCheckpoint> checkpoint =
        ParseCheckpoint(SerializeCheckpoint(trainer->Save()));
    ASSERT_TRUE(checkpoint.ok());
    EXPECT_EQ(checkpoint->iteration, report->iteration);
    trainer.emplace(options, Start(), 2.0, &images, pool);
    ASSERT_TRUE(trainer->Restore(std::move(checkpoint).value()).ok());
    // With and without being told to.
    if (++stopped % 2 == 0) {
      ASSERT_TRUE(trainer->Step().ok());
    } else {
      EXPECT_TRUE(trainer->FinishMilestone(nullptr).value());
    }
    EXPECT_FALSE(trainer->FinishMilestone(nullptr).value());
  }
  EXPECT_EQ(stopped, 4);
  EXPECT_EQ(SerializeCheckpoint(trainer->Save()),
            SerializeCheckpoint(whole.Save()));
}

}  // namespace
}  // namespace freegs::splat
