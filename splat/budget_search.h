// SPDX-License-Identifier: BSD-3-Clause
// How many Gaussians, and which SH degree, a scene needs: as many as
// photographs that training never sees still gain from.

#ifndef FREEGS_SPLAT_BUDGET_SEARCH_H_
#define FREEGS_SPLAT_BUDGET_SEARCH_H_

#include <cstdint>
#include <functional>
#include <vector>

#include "core/status.h"
#include "splat/gaussian_model.h"
#include "splat/importance.h"
#include "splat/mini_splatting.h"

namespace freegs::splat {

struct TrainerOptions;

// Mean PSNR in dB of a model on the holdout photographs. An error ends the
// search and is passed on.
using QualityJudge = std::function<StatusOr<double>(const GaussianModel&)>;

struct BudgetSearchOptions {
  // What the models tried are pruned by, as a share of the total importance;
  // ascending from 0. A few percent of it are many Gaussians: see
  // KeepCumulativeImportance.
  std::vector<double> prune_shares = {0, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32};

  // A smaller model is good enough while its PSNR is at most so many dB under
  // the best so far; then a lower SH degree likewise.
  double tolerance_db = 0.1;
  double sh_tolerance_db = 0.05;

  // Every trial trains for this share of the iterations, within bounds.
  double trial_share = 0.02;
  int min_trial_steps = 30;
  int max_trial_steps = 200;

  Status Check() const;
};

// One model tried: pruned to so many Gaussians of so high a degree and trained
// for a little while.
struct BudgetTrial {
  int64_t num_gaussians = 0;
  int sh_degree = 0;
  double holdout_psnr = 0;

  friend bool operator==(const BudgetTrial&, const BudgetTrial&) = default;
};

struct BudgetChoice {
  int64_t budget = 0;
  int sh_degree = 0;
  std::vector<BudgetTrial> trials;  // The evidence, in the order tried.

  friend bool operator==(const BudgetChoice&, const BudgetChoice&) = default;
};

// Goes down from `model`: prunes it by ever larger shares of its importance
// until the holdout suffers, then lowers the SH degree until it does. Every
// trial starts from `model` and trains at full size, on the same views in the
// same order. position_rate is the positions' learning rate in force, per unit
// of scene extent; no more than `limit` Gaussians (0: any number) are kept. The
// result is a function of the arguments: the same for any number of threads.
StatusOr<BudgetChoice> SearchBudget(const BudgetSearchOptions& options,
                                    const TrainerOptions& training,
                                    const MiniSplattingContext& context,
                                    ImportanceMetric metric,
                                    double position_rate,
                                    int64_t limit,
                                    const GaussianModel& model,
                                    const QualityJudge& judge);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_BUDGET_SEARCH_H_
