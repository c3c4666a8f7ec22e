// SPDX-License-Identifier: BSD-3-Clause
// How many Gaussians, and which SH degree, a scene needs: as many as
// photographs that training never sees still gain from.

#ifndef FREEGS_SPLAT_SEARCH_BUDGET_SEARCH_H_
#define FREEGS_SPLAT_SEARCH_BUDGET_SEARCH_H_

#include <cstdint>
#include <functional>
#include <vector>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "splat/scene/gaussian_model.h"
#include "splat/images/training_images.h"
#include "splat/train/budget_choice.h"
#include "splat/train/trainer.h"

namespace freegs::splat {

// Mean PSNR in dB of a model on the holdout photographs at a level of their
// image pyramid. An error ends the search and is passed on.
using QualityJudge =
    std::function<StatusOr<double>(const GaussianModel& model, int level)>;

struct BudgetSearchOptions {
  // Numbers of Gaussians tried, as shares of the limit; descending from 1.
  std::vector<double> shares = {1, 0.7, 0.5, 0.35, 0.25, 0.175, 0.125};

  // A smaller number is good enough while its PSNR is at most so many dB under
  // the best so far; then a lower SH degree likewise.
  double tolerance_db = 0.1;
  double sh_tolerance_db = 0.05;

  // Level of the image pyramid that the trials are made at.
  int level = 1;

  // Every trial trains for this share of the iterations, within bounds.
  double trial_share = 0.25;
  int min_trial_steps = 200;
  int max_trial_steps = 1000;

  Status Check() const;
};

// Trains whole models, short and on small images, with ever fewer Gaussians
// until the holdout suffers, then with ever lower SH degrees until it does.
// Numbers that the training does not come near are passed over. An
// image of a quarter of the pixels gets a quarter of the Gaussians, so a trial
// is cheap, and the number found is carried over by the number of pixels. All
// trials start from `initial` and see the same views in the same order.
// `training` holds the limit as its budget and the SH degree to begin with;
// `level` of the options is lowered where `images` has fewer. The result is a
// function of the arguments: the same for any number of threads. kInvalidArgument
// without a limit; kInterrupted when cancelled (null: never).
StatusOr<BudgetChoice> SearchBudget(const BudgetSearchOptions& options,
                                    const TrainerOptions& training,
                                    const GaussianModel& initial,
                                    double scene_extent,
                                    const QualityJudge& judge,
                                    TrainingImages* images,
                                    ThreadPool* pool,
                                    const CancellationToken* cancellation);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_SEARCH_BUDGET_SEARCH_H_
