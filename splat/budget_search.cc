// SPDX-License-Identifier: BSD-3-Clause

#include "splat/budget_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "splat/simplification.h"
#include "splat/trainer.h"

namespace freegs::splat {
namespace {

// What a trial does after it was cut down.
TrainerOptions TrialOptions(const BudgetSearchOptions& options,
                            const TrainerOptions& training,
                            double position_rate,
                            int sh_degree) {
  TrainerOptions trial = training;
  trial.judge = nullptr;
  trial.budget = 0;
  ScheduleOptions& schedule = trial.schedule;
  schedule.method = DensificationMethod::kNone;
  schedule.iterations =
      std::clamp(static_cast<int>(options.trial_share * schedule.iterations),
                 options.min_trial_steps,
                 options.max_trial_steps);
  schedule.resolution_steps.clear();
  schedule.sh_degree = sh_degree;
  schedule.sh_degree_interval = 0;
  schedule.sh_start = 0;
  trial.learning_rates.mean_initial = position_rate;
  trial.learning_rates.mean_final = position_rate;
  return trial;
}

}  // namespace

Status BudgetSearchOptions::Check() const {
  if (prune_shares.empty() || prune_shares.front() != 0 ||
      !(prune_shares.back() < 1) ||
      !std::is_sorted(prune_shares.begin(), prune_shares.end())) {
    return InvalidArgumentError(
        "the shares of a budget search must ascend from 0 and be under 1");
  }
  if (!(tolerance_db >= 0 && sh_tolerance_db >= 0)) {
    return InvalidArgumentError(
        "the tolerances of a budget search must not be negative");
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
                                    const MiniSplattingContext& context,
                                    ImportanceMetric metric,
                                    double position_rate,
                                    int64_t limit,
                                    const GaussianModel& model,
                                    const QualityJudge& judge) {
  const std::vector<float> importance =
      ComputeImportance(context, model, metric);
  BudgetChoice choice;
  // Tries a model, and says whether it is good enough beside the best so far.
  double best = -std::numeric_limits<double>::infinity();
  const auto attempt = [&](std::span<const uint32_t> kept,
                           int sh_degree,
                           double tolerance) -> StatusOr<bool> {
    GaussianModel candidate = model;
    candidate.Select(kept);
    candidate.SetShDegree(sh_degree);
    Trainer trainer(TrialOptions(options, training, position_rate, sh_degree),
                    std::move(candidate),
                    context.scene_extent,
                    context.images,
                    context.pool);
    while (!trainer.done()) {
      FREEGS_RETURN_IF_ERROR(trainer.Step().status());
    }
    FREEGS_ASSIGN_OR_RETURN(const double psnr, judge(trainer.model()));
    choice.trials.push_back(
        {static_cast<int64_t>(kept.size()), sh_degree, psnr});
    best = std::max(best, psnr);
    return psnr >= best - tolerance;
  };

  std::vector<uint32_t> chosen;
  for (const double share : options.prune_shares) {
    std::vector<uint32_t> kept =
        KeepCumulativeImportance(importance, 1 - share);
    if (kept.empty()) break;
    if (limit > 0 && kept.size() > static_cast<size_t>(limit)) {
      kept = MostImportant(importance, static_cast<size_t>(limit));
    }
    if (kept.size() == chosen.size()) continue;
    FREEGS_ASSIGN_OR_RETURN(
        const bool good, attempt(kept, model.sh_degree, options.tolerance_db));
    if (!good) break;
    chosen = std::move(kept);
  }
  if (chosen.empty()) {
    return UnusableResultError(
        "training: no Gaussian is visible in any photo when choosing their "
        "number; check the camera poses");
  }
  choice.budget = static_cast<int64_t>(chosen.size());
  choice.sh_degree = model.sh_degree;
  while (choice.sh_degree > 0) {
    FREEGS_ASSIGN_OR_RETURN(
        const bool good,
        attempt(chosen, choice.sh_degree - 1, options.sh_tolerance_db));
    if (!good) break;
    --choice.sh_degree;
  }
  return choice;
}

}  // namespace freegs::splat
