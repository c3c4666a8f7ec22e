// SPDX-License-Identifier: BSD-3-Clause

#include "splat/train/trainer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "splat/images/holdout.h"
#include "tests/splat/training_fixture.h"

namespace freegs::splat {
namespace {

class TrainerTest : public TrainingFixture {
 protected:
  // Every method, and Mini-Splatting near its paper, with what else there is.
  static std::vector<TrainerOptions> Everything(int iterations) {
    TrainerOptions all = NearPaperOptions(iterations);
    all.exposure.learn = true;
    all.antialiased = true;
    return {Options(iterations, DensificationMethod::kNone),
            Options(iterations, DensificationMethod::kGradient),
            Options(iterations, DensificationMethod::kMiniSplatting),
            all};
  }
};

TEST_F(TrainerTest, LearnsTheScene) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  for (const TrainerOptions& options : Everything(300)) {
    Trainer trainer(options, Start(), 2.0, &images, pool);
    const StatusOr<HoldoutReport> before =
        MeasureHoldout({.model = trainer.model(), .images = &images}, pool);
    ASSERT_TRUE(before.ok());
    ASSERT_TRUE(Finish(&trainer).ok());
    const StatusOr<HoldoutReport> after =
        MeasureHoldout({.model = trainer.model(), .images = &images}, pool);
    ASSERT_TRUE(after.ok());
    EXPECT_GT(after->mean_psnr, before->mean_psnr + 6)
        << static_cast<int>(options.schedule.method);
    EXPECT_EQ(trainer.model().sh_degree, 1);
    EXPECT_TRUE(trainer.recoveries().empty());
  }
}

// The distance of the Gaussian that is nearest to any camera.
double NearestToACamera(const GaussianModel& model,
                        const std::vector<View>& views) {
  double nearest = 1e9;
  for (const View& view : views) {
    const Eigen::Vector3d centre = CameraCentre(view.cam_from_world);
    for (size_t i = 0; i < model.size(); ++i) {
      const Eigen::Vector3d mean =
          Eigen::Vector3f::Map(&model.means[3 * i]).cast<double>();
      nearest = std::min(nearest, (mean - centre).norm());
    }
  }
  return nearest;
}

TEST_F(TrainerTest, CamerasAreKeptClear) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  GaussianModel start = Start();
  start.AppendFrom(start, 0);
  const View& view = views_[0];
  Eigen::Vector3f::Map(&start.means[3 * (start.size() - 1)]) =
      (view.cam_from_world.rotation.conjugate() *
       (Eigen::Vector3d(0, 0, 0.05) - view.cam_from_world.translation))
          .cast<float>();
  for (const DensificationMethod method :
       {DensificationMethod::kNone,
        DensificationMethod::kGradient,
        DensificationMethod::kMiniSplatting}) {
    TrainerOptions options = Options(40, method);
    options.clear_interval = 5;
    Trainer trainer(options, start, 2.0, &images, pool);
    ASSERT_TRUE(Finish(&trainer).ok());
    const double nearest = NearestToACamera(trainer.model(), views_);
    if (method == DensificationMethod::kNone) {
      EXPECT_LT(nearest, 0.1);
    } else {
      EXPECT_GT(nearest, 0.2);
    }
  }
}

TEST_F(TrainerTest, WhatNoPhotoSeesFades) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  GaussianModel start = Start();
  const size_t behind = start.size();
  start.AppendFrom(start, 0);
  Eigen::Vector3f::Map(&start.means[3 * behind]) = Eigen::Vector3f(0, 0, -50);
  for (const DensificationMethod method :
       {DensificationMethod::kNone, DensificationMethod::kGradient}) {
    TrainerOptions options = Options(40, method);
    options.schedule.densify_interval = 0;
    options.average_from = 1;
    Trainer trainer(options, start, 2.0, &images, pool);
    ASSERT_TRUE(Finish(&trainer).ok());
    const auto opacity = [behind](const GaussianModel& model) {
      return 1 / (1 + std::exp(-model.opacity_logits[behind]));
    };
    const double share =
        OpacityDecayShare(options.opacity_decay, views_.size());
    const double kept =
        method == DensificationMethod::kNone ? 1 : std::pow(1 - share, 40);
    EXPECT_NEAR(opacity(trainer.model()), kept * opacity(start), 1e-6);
  }
}

TEST_F(TrainerTest, TheResultIsTheMeanOfTheLastSteps) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  for (TrainerOptions& options : Everything(60)) {
    Trainer averaging(options, Start(), 2.0, &images, pool);
    options.average_from = 1;
    Trainer plain(options, Start(), 2.0, &images, pool);
    std::vector<double> sums;
    int count = 0;
    while (!plain.done()) {
      ASSERT_TRUE(plain.Step().ok());
      ASSERT_TRUE(averaging.Step().ok());
      const std::vector<float> model = AllParameters(plain.model());
      if (plain.iteration() > 54 && plain.iteration() % 2 == 0) {
        sums.resize(model.size());
        for (size_t i = 0; i < model.size(); ++i) sums[i] += model[i];
        ++count;
      }
      const std::vector<float> mean = AllParameters(averaging.model());
      ASSERT_EQ(mean.size(), model.size());
      for (size_t i = 0; i < mean.size(); ++i) {
        ASSERT_NEAR(mean[i], count == 0 ? model[i] : sums[i] / count, 1e-4)
            << "iteration " << plain.iteration();
      }
    }
    EXPECT_EQ(count, 3);
    EXPECT_NE(AllParameters(averaging.model()), AllParameters(plain.model()));
    EXPECT_EQ(averaging.model().antialiased, options.antialiased);
  }
}

TEST_F(TrainerTest, SameBytesForAnyNumberOfThreads) {
  for (const TrainerOptions& options : Everything(120)) {
    std::vector<float> undisturbed;
    for (const int threads : {1, 2, 3, 5}) {
      ThreadPool pool(threads);
      TrainingImages images = Images(pool);
      Trainer trainer(options, Start(), 2.0, &images, pool);
      ASSERT_TRUE(Finish(&trainer).ok());
      if (undisturbed.empty()) undisturbed = AllParameters(trainer.model());
      EXPECT_EQ(AllParameters(trainer.model()), undisturbed)
          << static_cast<int>(options.schedule.method) << ", " << threads
          << " threads";
    }
  }
}

TEST_F(TrainerTest, SameBytesAcrossARestore) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  for (TrainerOptions& options : Everything(120)) {
    const DensificationMethod method = options.schedule.method;
    options.snapshot_interval = 25;
    // As saved on the way of an undisturbed run: around every milestone (20,
    // 40, 60, 80), densification and snapshot.
    std::map<int64_t, std::string> saved;
    Trainer whole(options, Start(), 2.0, &images, pool);
    while (!whole.done()) {
      ASSERT_TRUE(whole.Step().ok());
      saved[whole.iteration()] = SerializeCheckpoint(whole.Save());
    }
    const size_t milestones =
        method == DensificationMethod::kMiniSplatting ? 4 : 0;
    EXPECT_EQ(whole.milestones().size(), milestones);
    for (const int stop :
         {1, 19, 20, 21, 37, 40, 59, 60, 61, 80, 111, 119, 120}) {
      StatusOr<TrainingCheckpoint> checkpoint = ParseCheckpoint(saved[stop]);
      ASSERT_TRUE(checkpoint.ok());
      Trainer trainer(options, Start(), 2.0, &images, pool);
      ASSERT_TRUE(trainer.Restore(std::move(checkpoint).value()).ok());
      ASSERT_TRUE(Finish(&trainer).ok());
      EXPECT_EQ(trainer.model().antialiased, options.antialiased);
      // History, moments and last good state included.
      EXPECT_EQ(SerializeCheckpoint(trainer.Save()), saved[120])
          << static_cast<int>(method) << ", stop " << stop;
    }
  }
}

TEST_F(TrainerTest, KeepsTheBudget) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  for (const int budget : {7, 60, 150}) {
    for (const int iterations : {1, 10, 200}) {
      TrainerOptions options =
          Options(iterations, DensificationMethod::kMiniSplatting);
      options.budget = budget;
      Trainer trainer(options, Start(), 2.0, &images, pool);
      size_t most = 0;
      while (!trainer.done()) {
        const StatusOr<StepReport> report = trainer.Step();
        ASSERT_TRUE(report.ok()) << report.status().message();
        most = std::max(most, report->num_gaussians);
      }
      EXPECT_LE(trainer.model().size(), static_cast<size_t>(budget));
      const double dense = options.mini_splatting.dense_factor * budget;
      EXPECT_LE(static_cast<double>(most), std::max(60.0, dense));
      EXPECT_TRUE(trainer.model().AllFinite());
    }
    if (budget < 60) continue;  // Initial points stay with this method.
    TrainerOptions options = Options(200, DensificationMethod::kGradient);
    options.budget = budget;
    Trainer trainer(options, Start(), 2.0, &images, pool);
    ASSERT_TRUE(Finish(&trainer).ok());
    EXPECT_LE(trainer.model().size(), static_cast<size_t>(budget));
  }
}

TEST_F(TrainerTest, ReportsMilestones) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  TrainerOptions options = Options(120, DensificationMethod::kMiniSplatting);
  options.budget = 90;
  options.mini_splatting.dense_factor = 2;
  Trainer trainer(options, Start(), 2.0, &images, pool);
  ASSERT_TRUE(Finish(&trainer).ok());
  ASSERT_EQ(trainer.milestones().size(), 4u);
  for (size_t k = 0; k < 4; ++k) {
    const MilestoneRecord& record = trainer.milestones()[k];
    const Milestone planned = trainer.schedule().milestones()[k];
    EXPECT_EQ(record.iteration, planned.iteration);
    EXPECT_EQ(record.event, planned.event);
  }
  EXPECT_EQ(trainer.milestones()[0].gaussians_before, 60u);
  EXPECT_EQ(trainer.milestones()[0].gaussians_after, 140u);  // 7/9 of 180.
  // 1.15 times as many as the pruning is to leave.
  EXPECT_LE(trainer.milestones()[2].gaussians_after, 103u);
  EXPECT_LE(trainer.milestones()[3].gaussians_after, 90u);
  EXPECT_EQ(trainer.milestones()[3].gaussians_after, trainer.model().size());
}

TEST_F(TrainerTest, SimplifiesWithSlackOnlyBeforeAPruning) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  struct Case {
    double slack;
    double prune_at;
    size_t simplified;
  };
  for (const auto& [slack, prune_at, simplified] :
       {Case{1.25, 1, 32}, Case{1.0, 2.0 / 3, 32}, Case{1.25, 2.0 / 3, 40}}) {
    TrainerOptions options = Options(120, DensificationMethod::kMiniSplatting);
    options.budget = 32;
    options.schedule.prune_at = prune_at;
    options.mini_splatting.simplify_slack = slack;
    options.mini_splatting.dense_factor = 3;
    ASSERT_TRUE(options.Check().ok());
    Trainer trainer(options, Start(), 2.0, &images, pool);
    ASSERT_TRUE(Finish(&trainer).ok());
    EXPECT_EQ(trainer.milestones()[2].gaussians_after, simplified);
    EXPECT_LE(trainer.model().size(), 32u);
  }
}

TEST_F(TrainerTest, GoesOnWithTheKeptGaussians) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  const TrainerOptions options =
      Options(120, DensificationMethod::kMiniSplatting);
  Trainer trainer(options, Start(), 2.0, &images, pool);
  while (trainer.iteration() < 60) ASSERT_TRUE(trainer.Step().ok());
  const AdamState state = trainer.Save().adam;
  const std::vector<float>& moments = state.second_moments.opacity_logits;
  EXPECT_GT(state.steps, 0);
  EXPECT_GT(*std::max_element(moments.begin(), moments.end()), 0.0f);
  EXPECT_EQ(trainer.model().sh_degree, 1);
  ASSERT_TRUE(Finish(&trainer).ok());
  EXPECT_EQ(trainer.model().sh_degree, 1);
}

TEST_F(TrainerTest, ColourDependsOnTheViewFromShStartOn) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  for (const DensificationMethod method :
       {DensificationMethod::kGradient, DensificationMethod::kMiniSplatting}) {
    for (const double start : {0.0, 0.5}) {
      TrainerOptions options = Options(120, method);
      options.schedule.depth_reinit_at.clear();
      options.schedule.sh_start = start;
      Trainer trainer(options, Start(), 2.0, &images, pool);
      // The first step of degree 1 is 1/30 of all after the start.
      const auto first = static_cast<int64_t>(120 * start) + 4;
      while (trainer.iteration() < first + 1) {
        EXPECT_EQ(trainer.model().sh_degree, 0);
        ASSERT_TRUE(trainer.Step().ok());
      }
      EXPECT_EQ(trainer.model().sh_degree, 1);
    }
  }
}

TEST_F(TrainerTest, MeasuresHoldoutAtALevel) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  for (int level = 0; level < 3; ++level) {
    const StatusOr<HoldoutReport> report = MeasureHoldout(
        {.model = truth_, .images = &images, .level = level}, pool);
    ASSERT_TRUE(report.ok()) << report.status().message();
    EXPECT_EQ(*MeasureHoldoutPsnr(
                  {.model = truth_, .images = &images, .level = level}, pool),
              report->mean_psnr);
    ASSERT_EQ(report->views.size(), 8u);
    EXPECT_EQ(report->views[0].rendered.width(), 96 >> level);
    EXPECT_EQ(report->views[0].rendered.height(), 72 >> level);
    EXPECT_GT(report->mean_psnr, level == 0 ? 40 : 12);
  }
}

TEST_F(TrainerTest, RefusesACheckpointThatDoesNotFit) {
  ThreadPool pool(1);
  TrainingImages images = Images(pool);
  Trainer trainer(Options(10), Start(), 2.0, &images, pool);
  TrainingCheckpoint checkpoint = trainer.Save();
  checkpoint.adam.first_moments.Resize(3);
  EXPECT_EQ(trainer.Restore(checkpoint).code(), StatusCode::kBadInput);
  checkpoint = trainer.Save();
  checkpoint.iteration = 11;
  const Status beyond = trainer.Restore(checkpoint);
  EXPECT_EQ(beyond.code(), StatusCode::kBadInput);
  EXPECT_NE(beyond.message().find("iteration 11, but the training has 10;"),
            std::string::npos);
  checkpoint = trainer.Save();
  checkpoint.history.average = {3, checkpoint.model};
  checkpoint.history.average.mean.Resize(3);
  EXPECT_EQ(trainer.Restore(checkpoint).code(), StatusCode::kBadInput);
  checkpoint = trainer.Save();
  checkpoint.history.last_good = {0, checkpoint.model, {}};
  checkpoint.history.last_good->colors.entries.resize(1);
  EXPECT_EQ(trainer.Restore(checkpoint).code(), StatusCode::kBadInput);
  checkpoint = trainer.Save();
  checkpoint.statistics.visible_steps.clear();
  EXPECT_EQ(trainer.Restore(checkpoint).code(), StatusCode::kBadInput);
  checkpoint = trainer.Save();
  checkpoint.history.last_good = {1, checkpoint.model, {}};
  EXPECT_EQ(trainer.Restore(checkpoint).code(), StatusCode::kBadInput);
  for (const Parameter parameter : kAllParameters) {
    checkpoint = trainer.Save();
    std::vector<float>& array = ParameterArray(checkpoint.model, parameter);
    if (array.empty()) continue;
    array.pop_back();
    EXPECT_EQ(trainer.Restore(checkpoint).code(), StatusCode::kBadInput);
  }
  EXPECT_TRUE(trainer.Restore(trainer.Save()).ok());
  EXPECT_TRUE(trainer.Step().ok());
}

TEST_F(TrainerTest, SaysSoWhenTheInitialNumbersAreNotFinite) {
  ThreadPool pool(1);
  TrainingImages images = Images(pool);
  GaussianModel start = Start();
  start.sh_dc[0] = NAN;
  Trainer trainer(Options(10), start, 2.0, &images, pool);
  EXPECT_EQ(trainer.GoBackUnlessFinite().status().code(),
            StatusCode::kUnusableResult);
  EXPECT_EQ(Finish(&trainer).code(), StatusCode::kUnusableResult);
}

TEST(TrainerOptions, CheckRefusesValuesOutOfRange) {
  EXPECT_TRUE(TrainerOptions().Check().ok());
  TrainerOptions options;
  options.schedule.iterations = 0;
  EXPECT_FALSE(options.Check().ok());
  options = TrainerOptions();
  options.schedule.sh_degree = 4;
  EXPECT_FALSE(options.Check().ok());
  options = TrainerOptions();
  options.schedule.resolution_steps = {0.5, 0.2};
  EXPECT_FALSE(options.Check().ok());
  options = TrainerOptions();
  options.budget = -1;
  EXPECT_FALSE(options.Check().ok());
  options = TrainerOptions();
  options.mini_splatting.dense_factor = 0.5;
  EXPECT_FALSE(options.Check().ok());
  options = TrainerOptions();
  options.opacity_decay.strength = -1;
  EXPECT_FALSE(options.Check().ok());
  options = TrainerOptions();
  options.decay_interval = 0;
  EXPECT_FALSE(options.Check().ok());
  options = TrainerOptions();
  options.average_from = 1.5;
  EXPECT_FALSE(options.Check().ok());
  options = TrainerOptions();
  options.budget = std::numeric_limits<int64_t>::max();
  EXPECT_FALSE(options.Check().ok());
  options = TrainerOptions();
  options.densification.split_shrink = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(options.Check().ok());
  for (const double near_plane : {-1.0, 0.0, std::nan("")}) {
    options = TrainerOptions();
    options.render.near_plane = near_plane;
    EXPECT_FALSE(options.Check().ok());
  }
}

}  // namespace
}  // namespace freegs::splat
