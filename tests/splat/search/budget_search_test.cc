// SPDX-License-Identifier: BSD-3-Clause
// The search stops where the judge says so, and training keeps to what it
// found.

#include "splat/search/budget_search.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/cancellation.h"
#include "splat/images/holdout.h"
#include "splat/train/checkpoint.h"
#include "splat/train/trainer.h"
#include "tests/splat/training_fixture.h"

namespace freegs::splat {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// What a judge was shown.
struct Seen {
  size_t size = 0;
  int sh_degree = 0;
  int level = 0;
};

class BudgetSearchTest : public TrainingFixture {
 protected:
  using Figure = std::function<double(size_t size, int sh_degree)>;

  // At most 200 Gaussians of degree 2. Trials at half size are of 50, 35, 25,
  // 17, 12, 8 and 6 and have 20 steps: a simplification to that number, no
  // pruning.
  static TrainerOptions Limits(int iterations = 80) {
    TrainerOptions options =
        Options(iterations, DensificationMethod::kMiniSplatting);
    options.schedule.sh_degree = 2;
    options.budget = 200;
    return options;
  }

  // A judge that goes by numbers only, and says what it saw.
  QualityJudge Judge(Figure figure) {
    return [this, figure](const GaussianModel& model,
                          int level) -> StatusOr<double> {
      seen_.push_back({model.size(), model.sh_degree, level});
      return figure(model.size(), model.sh_degree);
    };
  }

  // 25 Gaussians at half size, and degree 1, are as good as more.
  QualityJudge Plateau() {
    return Judge([](size_t size, int sh_degree) {
      return 30.0 - (size < 25 ? 0.5 : 0.0) - (sh_degree < 1 ? 0.2 : 0.0);
    });
  }

  StatusOr<BudgetChoice> Search(const TrainerOptions& training,
                                const QualityJudge& judge,
                                int threads = 2) {
    ThreadPool pool(threads);
    TrainingImages images = Images(pool);
    return SearchBudget(
        search_, training, Start(), 2.0, judge, &images, &pool, &cancellation_);
  }

  BudgetSearchOptions search_{.min_trial_steps = 20, .max_trial_steps = 20};
  CancellationToken cancellation_;

  std::vector<Seen> seen_;
};

TEST_F(BudgetSearchTest, FindsThePlateauAndStopsAtTheFirstFailure) {
  const StatusOr<BudgetChoice> choice = Search(Limits(), Plateau());
  ASSERT_TRUE(choice.ok()) << choice.status().message();
  EXPECT_EQ(choice->budget, 100);
  EXPECT_EQ(choice->sh_degree, 1);
  EXPECT_THAT(choice->trials,
              ElementsAre(BudgetTrial{50, 2, 30.0},
                          BudgetTrial{35, 2, 30.0},
                          BudgetTrial{25, 2, 30.0},
                          BudgetTrial{17, 2, 29.5},
                          BudgetTrial{25, 1, 30.0},
                          BudgetTrial{25, 0, 29.8}));
  // The judge saw just these models, at half size.
  ASSERT_EQ(seen_.size(), choice->trials.size());
  for (size_t k = 0; k < seen_.size(); ++k) {
    EXPECT_EQ(seen_[k].size, static_cast<size_t>(choice->trials[k].budget));
    EXPECT_EQ(seen_[k].sh_degree, choice->trials[k].sh_degree);
    EXPECT_EQ(seen_[k].level, 1);
  }
}

TEST_F(BudgetSearchTest, GoesToTheEndWhenNothingIsLost) {
  const StatusOr<BudgetChoice> choice =
      Search(Limits(), Judge([](size_t, int) { return 20.0; }));
  ASSERT_TRUE(choice.ok());
  EXPECT_EQ(choice->budget, 25);
  EXPECT_EQ(choice->sh_degree, 0);
  EXPECT_EQ(choice->trials.size(), 9u);
  EXPECT_EQ(choice->trials[6].budget, 6);
}

TEST_F(BudgetSearchTest, TheLimitStaysWhenLessIsWorse) {
  const StatusOr<BudgetChoice> choice =
      Search(Limits(), Judge([](size_t size, int sh_degree) {
               return static_cast<double>(size) + sh_degree;
             }));
  ASSERT_TRUE(choice.ok());
  EXPECT_EQ(choice->budget, 200);
  EXPECT_EQ(choice->sh_degree, 2);
  // One smaller number, one lower degree.
  EXPECT_EQ(choice->trials.size(), 3u);
}

// Small losses must not add up.
TEST_F(BudgetSearchTest, ToleranceIsAgainstTheBest) {
  int calls = 0;
  const StatusOr<BudgetChoice> choice = Search(
      Limits(), Judge([&](size_t, int) { return 30.0 - 0.04 * calls++; }));
  ASSERT_TRUE(choice.ok());
  // 30, 29.96, 29.92, 29.88: the fourth has lost more than 0.1.
  EXPECT_EQ(choice->budget, 100);
  // The degree is measured against 29.92: 29.84 has lost more than 0.05.
  EXPECT_EQ(choice->sh_degree, 2);
  EXPECT_EQ(choice->trials.size(), 5u);
}

TEST_F(BudgetSearchTest, AFigureThatIsNoNumberIsNotGood) {
  const StatusOr<BudgetChoice> choice =
      Search(Limits(), Judge([](size_t, int) { return std::nan(""); }));
  ASSERT_TRUE(choice.ok());
  EXPECT_EQ(choice->budget, 200);
  EXPECT_EQ(choice->sh_degree, 2);
  // Likewise for one without any error.
  const StatusOr<BudgetChoice> perfect = Search(
      Limits(), Judge([](size_t size, int) {
        return size < 50 ? 60.0 : std::numeric_limits<double>::infinity();
      }));
  ASSERT_TRUE(perfect.ok());
  EXPECT_EQ(perfect->budget, 200);
}

// 2000 at most are 500 at half size; the trial begins with 60 and stays there.
TEST_F(BudgetSearchTest, BoundsThatDoNotBindArePassedOver) {
  TrainerOptions options = Limits();
  options.budget = 2000;
  const StatusOr<BudgetChoice> choice =
      Search(options, Judge([](size_t, int) { return 20.0; }));
  ASSERT_TRUE(choice.ok()) << choice.status().message();
  EXPECT_EQ(choice->budget, 2000);
  EXPECT_THAT(choice->trials,
              ElementsAre(BudgetTrial{500, 2, 20.0},
                          BudgetTrial{500, 1, 20.0},
                          BudgetTrial{500, 0, 20.0}));
}

TEST_F(BudgetSearchTest, LevelIsOneThatTheImagesHave) {
  ThreadPool pool(2);
  StatusOr<TrainingImages> images =
      TrainingImages::Load(views_, folder_, {.num_levels = 1}, pool);
  ASSERT_TRUE(images.ok());
  TrainerOptions options = Limits();
  options.budget = 50;
  options.schedule.sh_degree = 0;
  search_.shares = {1, 0.5};
  const StatusOr<BudgetChoice> choice =
      SearchBudget(search_,
                   options,
                   Start(),
                   2.0,
                   Judge([](size_t, int) { return 20.0; }),
                   &*images,
                   &pool,
                   nullptr);
  ASSERT_TRUE(choice.ok()) << choice.status().message();
  EXPECT_EQ(choice->budget, 25);
  EXPECT_THAT(choice->trials,
              ElementsAre(BudgetTrial{50, 0, 20.0}, BudgetTrial{25, 0, 20.0}));
  EXPECT_EQ(seen_[0].level, 0);
}

TEST_F(BudgetSearchTest, ALimitOfOne) {
  TrainerOptions options = Limits();
  options.budget = 1;
  const StatusOr<BudgetChoice> choice =
      Search(options, Judge([](size_t, int sh_degree) { return sh_degree; }));
  ASSERT_TRUE(choice.ok()) << choice.status().message();
  EXPECT_EQ(choice->budget, 1);
  EXPECT_EQ(choice->sh_degree, 2);
}

TEST_F(BudgetSearchTest, TrialsDensifyAsTrainingDoes) {
  for (const int interval : {0, 20}) {
    TrainerOptions options = Limits();
    options.budget = 4000;
    options.schedule.sh_degree = 0;
    options.schedule.densify_interval = interval;
    options.densification.gradient_threshold = 1e-9;
    search_ = {.shares = {1}, .min_trial_steps = 60, .max_trial_steps = 60};
    seen_.clear();
    const StatusOr<BudgetChoice> choice =
        Search(options, Judge([](size_t, int) { return 20.0; }));
    ASSERT_TRUE(choice.ok()) << choice.status().message();
    ASSERT_EQ(seen_.size(), 1u);
    EXPECT_EQ(seen_[0].size > 60, interval > 0) << seen_[0].size;
  }
}

TEST_F(BudgetSearchTest, PassesOnTheErrorOfTheJudge) {
  int calls = 0;
  const QualityJudge judge = [&](const GaussianModel&,
                                 int) -> StatusOr<double> {
    if (++calls == 2) return BadInputError("the photo is gone");
    return 30.0;
  };
  const StatusOr<BudgetChoice> choice = Search(Limits(), judge);
  EXPECT_EQ(choice.status().code(), StatusCode::kBadInput);
  EXPECT_THAT(choice.status().message(), HasSubstr("the photo is gone"));
  EXPECT_EQ(calls, 2);

  // What comes after the error is a search of its own.
  const StatusOr<BudgetChoice> again = Search(Limits(), judge);
  ASSERT_TRUE(again.ok()) << again.status().message();
  EXPECT_EQ(again->budget, 25);
  EXPECT_EQ(again->trials.size(), 9u);
}

TEST_F(BudgetSearchTest, StopsWhenCancelled) {
  // While the third model is judged; the fourth is not trained to its end.
  const StatusOr<BudgetChoice> choice =
      Search(Limits(), Judge([&](size_t, int) {
               if (seen_.size() == 3) cancellation_.Cancel();
               return 20.0;
             }));
  EXPECT_EQ(choice.status().code(), StatusCode::kInterrupted);
  EXPECT_EQ(seen_.size(), 3u);
}

TEST_F(BudgetSearchTest, NeedsALimit) {
  TrainerOptions options = Limits();
  options.budget = 0;
  EXPECT_EQ(Search(options, Plateau()).status().code(),
            StatusCode::kInvalidArgument);
  EXPECT_TRUE(seen_.empty());
}

TEST_F(BudgetSearchTest, SameChoiceForAnyNumberOfThreads) {
  BudgetChoice first;
  for (const int threads : {1, 3}) {
    ThreadPool pool(threads);
    TrainingImages images = Images(pool);
    const QualityJudge judge = [&](const GaussianModel& model,
                                   int level) -> StatusOr<double> {
      FREEGS_ASSIGN_OR_RETURN(
          const HoldoutReport report,
          MeasureHoldout(model, RenderOptions(), &images, pool, level));
      return report.mean_psnr;
    };
    const StatusOr<BudgetChoice> choice = Search(Limits(), judge, threads);
    ASSERT_TRUE(choice.ok()) << choice.status().message();
    EXPECT_GE(choice->trials.size(), 2u);
    if (threads == 1) first = *choice;
    EXPECT_EQ(*choice, first);  // Figures to the last bit.
  }
}

TEST_F(BudgetSearchTest, TrainingKeepsToTheChoice) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  TrainerOptions options = Limits(120);
  options.mini_splatting.dense_factor = 2;
  ASSERT_TRUE(options.Check().ok());
  Trainer trainer(options, Start(), 2.0, &images, &pool);
  EXPECT_FALSE(trainer.budget_choice().has_value());
  const StatusOr<BudgetChoice> choice = Search(options, Plateau());
  ASSERT_TRUE(choice.ok()) << choice.status().message();
  trainer.KeepTo(*choice);
  size_t most = 0;
  while (!trainer.done()) {
    const StatusOr<StepReport> report = trainer.Step();
    ASSERT_TRUE(report.ok()) << report.status().message();
    most = std::max(most, report->num_gaussians);
  }
  EXPECT_EQ(trainer.budget_choice(), *choice);
  EXPECT_EQ(choice->budget, 100);
  EXPECT_EQ(choice->sh_degree, 1);
  EXPECT_EQ(seen_.size(), 6u);
  EXPECT_EQ(trainer.model().sh_degree, 1);
  EXPECT_LE(trainer.model().size(), 100u);
  EXPECT_LE(most, 200u);
  ASSERT_EQ(trainer.milestones().size(), 4u);
  // From depth maps there are 7/9 of twice the number.
  EXPECT_EQ(trainer.milestones()[0].gaussians_after, 156u);
  EXPECT_LE(trainer.milestones()[2].gaussians_after, 115u);

  // As if the number and degree had been given.
  TrainerOptions given = Limits(120);
  given.mini_splatting.dense_factor = 2;
  given.budget = 100;
  given.schedule.sh_degree = 1;
  Trainer plain(given, Start(), 2.0, &images, &pool);
  ASSERT_TRUE(Finish(&plain).ok());
  EXPECT_EQ(AllParameters(plain.model()), AllParameters(trainer.model()));
}

TEST_F(BudgetSearchTest, TrainingWithoutAChoiceGoesByItsOptions) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  for (const DensificationMethod method :
       {DensificationMethod::kNone,
        DensificationMethod::kGradient,
        DensificationMethod::kMiniSplatting}) {
    TrainerOptions options = Limits(20);
    options.schedule.method = method;
    Trainer trainer(options, Start(), 2.0, &images, &pool);
    ASSERT_TRUE(Finish(&trainer).ok());
    EXPECT_FALSE(trainer.budget_choice().has_value());
    EXPECT_EQ(trainer.model().sh_degree, 2);
  }
}

TEST_F(BudgetSearchTest, ARestoredTrainingKeepsToItsChoice) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  TrainerOptions options = Limits(120);
  const StatusOr<BudgetChoice> choice = Search(options, Plateau());
  ASSERT_TRUE(choice.ok()) << choice.status().message();
  std::map<int64_t, std::string> saved;
  Trainer whole(options, Start(), 2.0, &images, &pool);
  whole.KeepTo(*choice);
  while (!whole.done()) {
    ASSERT_TRUE(whole.Step().ok());
    saved[whole.iteration()] = SerializeCheckpoint(whole.Save());
  }
  ASSERT_EQ(whole.budget_choice(), *choice);
  for (const int stop : {1, 19, 40, 59, 60, 61, 80, 119, 120}) {
    StatusOr<TrainingCheckpoint> checkpoint = ParseCheckpoint(saved[stop]);
    ASSERT_TRUE(checkpoint.ok());
    EXPECT_EQ(checkpoint->history.budget_choice, *choice);
    Trainer trainer(options, Start(), 2.0, &images, &pool);
    ASSERT_TRUE(trainer.Restore(std::move(checkpoint).value()).ok());
    EXPECT_EQ(trainer.budget_choice(), *choice);
    ASSERT_TRUE(Finish(&trainer).ok());
    EXPECT_EQ(SerializeCheckpoint(trainer.Save()), saved[120]) << stop;
  }
}

TEST_F(BudgetSearchTest, ChecksItsOptions) {
  EXPECT_TRUE(BudgetSearchOptions().Check().ok());
  EXPECT_TRUE(BudgetSearchOptions{.shares = {1}}.Check().ok());
  const double nan = std::nan("");
  const std::vector<BudgetSearchOptions> wrong = {
      {.shares = {}},
      {.shares = {0.5, 0.25}},
      {.shares = {1, 0.25, 0.5}},
      {.shares = {1, 0}},
      {.shares = {1, -1}},
      {.shares = {1, nan}},
      {.tolerance_db = -0.1},
      {.tolerance_db = nan},
      {.sh_tolerance_db = -0.1},
      {.level = -1},
      {.trial_share = -0.1},
      {.trial_share = 1.5},
      {.trial_share = nan},
      {.min_trial_steps = 0},
      {.min_trial_steps = 10, .max_trial_steps = 9},
  };
  for (size_t k = 0; k < wrong.size(); ++k) {
    EXPECT_EQ(wrong[k].Check().code(), StatusCode::kInvalidArgument) << k;
    search_ = wrong[k];
    EXPECT_EQ(Search(Limits(), Plateau()).status().code(),
              StatusCode::kInvalidArgument)
        << k;
  }
  EXPECT_TRUE(seen_.empty());
}

}  // namespace
}  // namespace freegs::splat
