// SPDX-License-Identifier: BSD-3-Clause
// Chooses how many Gaussians and which SH degree a scene needs: the fewest with
// which the photographs that training never sees still look about as good as
// with more.
//
//   const QualityJudge judge = [&](const GaussianModel& model,
//                                  int level) -> StatusOr<double> {
//     FREEGS_ASSIGN_OR_RETURN(
//         const HoldoutReport report,
//         MeasureHoldout(model, RenderOptions(), &holdout, pool, level));
//     return report.mean_psnr;
//   };
//   FREEGS_ASSIGN_OR_RETURN(
//       BudgetChoice choice,
//       SearchBudget({}, training, trainer.model(), extent, judge, &images,
//                    &pool, nullptr));
//   trainer.KeepTo(std::move(choice));

#ifndef FREEGS_SPLAT_SEARCH_BUDGET_SEARCH_H_
#define FREEGS_SPLAT_SEARCH_BUDGET_SEARCH_H_

#include <cstdint>
#include <functional>
#include <vector>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "splat/images/training_images.h"
#include "splat/scene/gaussian_model.h"
#include "splat/train/budget_choice.h"
#include "splat/train/trainer.h"

namespace freegs::splat {

// Returns the mean PSNR in dB of a model on the holdout photographs, at a level
// of their image pyramid. An error ends the search, which returns it.
using QualityJudge =
    std::function<StatusOr<double>(const GaussianModel& model, int level)>;

struct BudgetSearchOptions {
  // The numbers of Gaussians to try, as shares of the limit, descending from 1.
  std::vector<double> shares = {1, 0.7, 0.5, 0.35, 0.25, 0.175, 0.125};

  // A smaller number of Gaussians is good enough if its PSNR is at most
  // tolerance_db below the best so far. A lower SH degree is good enough if its
  // PSNR is at most sh_tolerance_db below the best with that number of
  // Gaussians.
  double tolerance_db = 0.1;
  double sh_tolerance_db = 0.05;

  // The level of the image pyramid with which the trials are made.
  int level = 1;

  // A trial has this share of the iterations of the training, within the
  // bounds.
  double trial_share = 0.25;
  int min_trial_steps = 200;
  int max_trial_steps = 1000;

  Status Check() const;
};

// Makes short trainings on small images, the trials. They have fewer and fewer
// Gaussians until the PSNR is no longer good enough, and then, with the last
// number that was, lower and lower SH degrees until it is not. A number of
// Gaussians that is no limit to the training, because the trial before never
// had so many, is not tried. A trial on images with a quarter of the pixels has
// a quarter of the Gaussians; the number chosen is that for full size. All
// trials begin with `initial` and use the same views in the same order.
//
// training.budget is the limit, training.schedule.sh_degree the degree to begin
// with. When `images` has too few levels for options.level, the coarsest is
// used. The result is the same for any number of threads. Fails with
// kInvalidArgument when there is no limit or the options are wrong, and with
// kInterrupted when `cancellation` (null: never) asks to stop.
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
