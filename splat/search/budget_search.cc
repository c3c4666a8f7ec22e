// SPDX-License-Identifier: BSD-3-Clause

#include "splat/search/budget_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace freegs::splat {
namespace {

// The options of a trial. Milestones are shares of the iterations and adapt by
// themselves; intervals must be shortened.
TrainerOptions TrialOptions(const BudgetSearchOptions& options,
                            const TrainerOptions& training,
                            int level) {
  TrainerOptions trial = training;
  ScheduleOptions& schedule = trial.schedule;
  const int wanted =
      std::clamp(static_cast<int>(options.trial_share * schedule.iterations),
                 options.min_trial_steps,
                 options.max_trial_steps);
  const int steps = std::min(wanted, schedule.iterations);
  const double shorter = std::min(1.0, 1.0 * steps / schedule.iterations);
  schedule.iterations = steps;
  schedule.finest_level = std::max(schedule.finest_level, level);
  schedule.depth_reinit_at.clear();
  if (schedule.densify_interval > 0) {
    schedule.densify_interval =
        std::max(10, static_cast<int>(schedule.densify_interval * shorter));
  }
  trial.learning_rates.mean_decay_steps = steps;
  return trial;
}

}  // namespace

Status BudgetSearchOptions::Check() const {
  if (shares.empty() || shares.front() != 1 || !(shares.back() > 0) ||
      !std::is_sorted(shares.rbegin(), shares.rend())) {
    return InvalidArgumentError(
        "the shares of a budget search must descend from 1 and be positive");
  }
  if (!(tolerance_db >= 0 && sh_tolerance_db >= 0) || level < 0) {
    return InvalidArgumentError(
        "level and tolerances of a budget search must not be negative");
  }
  if (!(trial_share >= 0 && trial_share <= 1) || min_trial_steps < 1 ||
      max_trial_steps < min_trial_steps) {
    return InvalidArgumentError(
        "the steps of a budget search's trials must be positive");
  }
  return Status();
}

StatusOr<BudgetChoice> SearchBudget(const BudgetSearchOptions& options,
                                    const TrainerOptions& training,
                                    const GaussianModel& initial,
                                    double scene_extent,
                                    const QualityJudge& judge,
                                    TrainingImages* images,
                                    ThreadPool* pool,
                                    const CancellationToken* cancellation) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  if (training.budget <= 0) {
    return InvalidArgumentError("a search for a budget needs a limit");
  }
  const int level = std::min(options.level, images->num_levels() - 1);
  const double pixels = std::pow(0.25, level);
  const auto at_level = [pixels](int64_t budget) {
    return std::max<int64_t>(
        1, static_cast<int64_t>(pixels * static_cast<double>(budget)));
  };
  BudgetChoice choice;
  // Makes a trial, and returns whether its PSNR is good enough in comparison
  // with the best so far. `most` becomes the largest number of Gaussians that
  // the trial had at any time.
  size_t most = 0;
  double best = -std::numeric_limits<double>::infinity();
  const auto attempt =
      [&](int64_t budget, int sh_degree, double tolerance) -> StatusOr<bool> {
    TrainerOptions trial = TrialOptions(options, training, level);
    trial.budget = at_level(budget);
    trial.schedule.sh_degree = sh_degree;
    Trainer trainer(trial, initial, scene_extent, images, pool);
    most = initial.size();
    while (!trainer.done()) {
      if (cancellation != nullptr && cancellation->cancelled()) {
        return InterruptedError(
            "training: stopped while choosing the number of Gaussians");
      }
      FREEGS_RETURN_IF_ERROR(trainer.Step().status());
      most = std::max(most, trainer.model().size());
    }
    FREEGS_ASSIGN_OR_RETURN(const double psnr, judge(trainer.model(), level));
    choice.trials.push_back({trial.budget, sh_degree, psnr});
    best = std::max(best, psnr);
    return psnr >= best - tolerance;
  };

  choice.sh_degree = training.schedule.sh_degree;
  choice.budget = training.budget;
  for (const double share : options.shares) {
    const auto budget =
        static_cast<int64_t>(share * static_cast<double>(training.budget));
    // A limit that the last trial never reached would lead to the same model
    // again.
    if (!choice.trials.empty() &&
        static_cast<uint64_t>(at_level(budget)) >= most) {
      continue;
    }
    FREEGS_ASSIGN_OR_RETURN(
        const bool good,
        attempt(budget, choice.sh_degree, options.tolerance_db));
    if (!good) break;
    choice.budget = std::max<int64_t>(1, budget);
  }
  // Lower degrees are compared with the trial that had the chosen number.
  best = -std::numeric_limits<double>::infinity();
  for (const BudgetTrial& trial : choice.trials) {
    if (trial.budget == at_level(choice.budget)) best = trial.holdout_psnr;
  }
  while (choice.sh_degree > 0) {
    FREEGS_ASSIGN_OR_RETURN(
        const bool good,
        attempt(choice.budget, choice.sh_degree - 1, options.sh_tolerance_db));
    if (!good) break;
    --choice.sh_degree;
  }
  return choice;
}

}  // namespace freegs::splat
