// SPDX-License-Identifier: BSD-3-Clause
// Phase 1: fits Gaussians to posed photographs.

#ifndef FREEGS_SPLAT_TRAIN_TRAINER_H_
#define FREEGS_SPLAT_TRAIN_TRAINER_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"
#include "splat/optim/adam.h"
#include "splat/train/budget_choice.h"
#include "splat/density/camera_clearance.h"
#include "splat/train/checkpoint.h"
#include "splat/density/densification.h"
#include "splat/scene/gaussian_model.h"
#include "splat/density/importance.h"
#include "splat/optim/learning_rates.h"
#include "splat/optim/loss.h"
#include "splat/density/mini_splatting.h"
#include "splat/render/rasterizer.h"
#include "splat/render/renderer.h"
#include "splat/train/stability.h"
#include "splat/train/training_history.h"
#include "splat/images/training_images.h"
#include "splat/train/training_schedule.h"
#include "splat/images/view_order.h"

namespace freegs::splat {

struct TrainerOptions {
  ScheduleOptions schedule;

  // Gaussians of the result, at most; 0 is no limit. kGradient stops adding at
  // this number (initial points beyond it stay); kMiniSplatting keeps so many
  // at the simplification, after having had up to dense_factor times as many.
  int64_t budget = 0;

  MiniSplattingOptions mini_splatting;

  // How importance is measured; nothing chooses by how the initial points lie
  // around the cameras, see ChooseImportanceMetric.
  std::optional<ImportanceMetric> importance;

  // A budget overrides max_gaussians; the method decides about
  // blur_split_share.
  DensificationOptions densification;

  // Gaussians that come this near to a training camera are removed every
  // clear_interval steps, but for the last tenth of them, which would leave no
  // time to fill the holes. kNone removes none.
  CameraClearanceOptions clearance;
  int clear_interval = 50;

  LearningRateOptions learning_rates;
  PhotometricLossOptions loss;
  RenderOptions render;
  uint64_t seed = 0;

  // The state to come back to when training diverges is renewed every so many
  // iterations, and at milestones.
  int snapshot_interval = 500;

  // Training gives up when it diverges once more than this.
  int max_recoveries = 5;

  Status Check() const;
};

// The result of one step.
struct StepReport {
  // Steps done. Smaller than before the step when `recovered`.
  int64_t iteration = 0;
  float loss = 0;  // Of the step; perhaps not finite when `recovered`.
  size_t num_gaussians = 0;
  bool recovered = false;  // Training had diverged and has gone back.
};

// Usage:
//   Trainer trainer(options, initial_model, extent, &images, &pool);
//   while (!trainer.done()) { trainer.Step(); ... }
//   WritePly(path, trainer.model());
// The state after k steps depends on the inputs, options and seed only: not on
// the number of threads, nor on having been saved and restored in between.
//
// When a parameter or the loss is not finite, or the loss explodes, training
// goes back to its last good state, with zero moments, and on from there with
// all learning rates halved for good.
class Trainer {
 public:
  // `images` (one view or more) and `pool` must outlive the trainer.
  // scene_extent in world units, see SceneExtent. The options must pass
  // Check().
  Trainer(const TrainerOptions& options,
          GaussianModel initial_model,
          double scene_extent,
          TrainingImages* images,
          ThreadPool* pool);

  bool done() const { return iteration_ >= schedule_.iterations(); }
  int64_t iteration() const { return iteration_; }
  const GaussianModel& model() const { return model_; }
  const TrainingSchedule& schedule() const { return schedule_; }
  ImportanceMetric importance_metric() const { return importance_metric_; }

  // What has happened so far, by iteration.
  const std::vector<MilestoneRecord>& milestones() const {
    return history_.milestones;
  }
  const std::vector<Recovery>& recoveries() const {
    return history_.recoveries;
  }
  const std::optional<BudgetChoice>& budget_choice() const {
    return history_.budget_choice;
  }

  // Keeps training to the number of Gaussians and the SH degree that a search
  // found (splat/search/budget_search.h), as if the options had named them.
  // Call it before the first step. The choice becomes part of the history, so a
  // restored training keeps to it without another search.
  void KeepTo(BudgetChoice choice);

  // One gradient step, and what the schedule wants after it. kUnusableResult
  // when training keeps diverging or no Gaussian is left or visible, kBadInput
  // when a photo has become unreadable.
  StatusOr<StepReport> Step();

  // Everything needed to go on later. Restore refuses a checkpoint whose arrays
  // do not fit together.
  TrainingCheckpoint Save() const;
  Status Restore(TrainingCheckpoint checkpoint);

 private:
  StatusOr<float> GradientStep();
  std::optional<std::string> FindTrouble(float loss);
  Status GoBack(const std::string& reason);
  Status FollowSchedule();
  Status RunMilestone(TrainingEvent event);
  int64_t Budget() const;
  int64_t SimplificationBudget() const;
  int ShDegree(int64_t done) const;
  void SortInSpace();  // What lies together is stored together.
  void ClearCameras();
  void KeepAsGood();

  TrainerOptions options_;
  DensificationOptions densification_;  // With budget and method.
  TrainingSchedule schedule_;
  double scene_extent_;
  TrainingImages* images_;
  ThreadPool* pool_;
  ImportanceMetric importance_metric_;
  std::vector<ClearBall> clear_balls_;
  ViewOrder view_order_;

  int64_t iteration_ = 0;
  GaussianModel model_;
  Adam adam_;
  DensificationStatistics statistics_;
  LossMonitor loss_monitor_;
  TrainingHistory history_;  // But for `loss`, which is in loss_monitor_.

  // Scratch of a step.
  Rasterizer rasterizer_;
  PhotometricLoss loss_;
  RasterImages rendered_;
  ImageF target_;
  ImageF loss_gradient_;
  std::vector<float> radii_;
  bool touched_finite_ = true;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_TRAIN_TRAINER_H_
