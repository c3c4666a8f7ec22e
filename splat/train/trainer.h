// SPDX-License-Identifier: BSD-3-Clause
// Fits Gaussians to photographs whose cameras are known: the first phase of the
// method.

#ifndef FREEGS_SPLAT_TRAIN_TRAINER_H_
#define FREEGS_SPLAT_TRAIN_TRAINER_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "splat/density/camera_clearance.h"
#include "splat/density/densification.h"
#include "splat/density/importance.h"
#include "splat/density/mini_splatting.h"
#include "splat/density/opacity_decay.h"
#include "splat/images/training_images.h"
#include "splat/images/view_order.h"
#include "splat/optim/adam.h"
#include "splat/optim/exposure.h"
#include "splat/optim/learning_rates.h"
#include "splat/optim/loss.h"
#include "splat/render/rasterizer.h"
#include "splat/render/renderer.h"
#include "splat/scene/gaussian_model.h"
#include "splat/train/checkpoint.h"
#include "splat/train/exposure_choice.h"
#include "splat/train/stability.h"
#include "splat/train/training_history.h"
#include "splat/train/training_schedule.h"

namespace freegs::splat {

struct TrainerOptions {
  ScheduleOptions schedule;

  // The largest number of Gaussians of the result; 0 is no limit. kGradient
  // adds none beyond this number, but keeps all initial points. kMiniSplatting
  // keeps so many at the simplification, and before that may have up to
  // mini_splatting.dense_factor times as many.
  int64_t budget = 0;

  MiniSplattingOptions mini_splatting;

  // With a budget, max_gaussians follows from it. blur_split_share is that of
  // mini_splatting for kMiniSplatting, else 0.
  DensificationOptions densification;

  // Gaussians too near to a training camera are removed every clear_interval
  // steps. The last tenth of the steps removes none, for it would be too short
  // to fill the holes. DensificationMethod::kNone never removes any.
  CameraClearanceOptions clearance;
  int clear_interval = 50;

  // Opacity fades where photographs are few, every decay_interval steps.
  // DensificationMethod::kNone lets nothing fade.
  OpacityDecayOptions opacity_decay;
  int decay_interval = 10;

  // The result is the mean of the models after every second step from this
  // share of the steps on; 1 takes the last model as it is. No Gaussian is
  // added or removed by then, see clear_interval.
  double average_from = 0.9;

  LearningRateOptions learning_rates;
  PhotometricLossOptions loss;
  ExposureOptions exposure;
  RenderOptions render;

  // GaussianModel::antialiased of the result.
  bool antialiased = false;

  uint64_t seed = 0;

  // The state to which training goes back when it diverges is renewed every so
  // many iterations, and at milestones.
  int snapshot_interval = 500;

  // Training fails when it diverges more often than this.
  int max_recoveries = 5;

  Status Check() const;
};

// The result of one step.
struct StepReport {
  // Number of steps made. Smaller than before the step when `recovered`.
  int64_t iteration = 0;
  float loss = 0;  // May be not finite when `recovered`.
  size_t num_gaussians = 0;
  bool recovered = false;  // Training diverged and went back to a good state.

  // The milestone after this step was cancelled. The model is as it was before
  // the milestone, and can be saved: FinishMilestone goes on from here.
  bool interrupted = false;
};

//   Trainer trainer(options, initial_model, extent, &images, pool);
//   while (!trainer.done()) {
//     FREEGS_RETURN_IF_ERROR(trainer.Step().status());
//   }
//   FREEGS_RETURN_IF_ERROR(WritePly("point_cloud.ply", trainer.model()));
//
// The state after k steps depends on the inputs, the options and the seed. It
// does not depend on the number of threads, nor on whether the training was
// saved and restored in between.
//
// When a parameter or the loss is not finite, or the loss grows far above its
// best (LossMonitor), training has diverged. It then goes back to its last good
// state, sets the moments of the optimiser to zero, halves all learning rates
// for the rest of the training, and goes on.
class Trainer {
 public:
  // `images` (one view or more) and `pool` must outlive the trainer.
  // scene_extent is in units of the model frame, see SceneExtent. The options
  // must pass Check().
  Trainer(const TrainerOptions& options,
          GaussianModel initial_model,
          double scene_extent,
          TrainingImages* images,
          ThreadPool& pool);

  bool done() const { return iteration_ >= schedule_.iterations(); }
  int64_t iteration() const { return iteration_; }

  // What has been learnt so far: the model after the last step, or the mean of
  // the last ones where TrainerOptions::average_from has been passed. Valid
  // until the next step.
  const GaussianModel& model() const {
    return history_.average.count > 0 ? history_.average.mean : model_;
  }
  const TrainerOptions& options() const { return options_; }
  const TrainingSchedule& schedule() const { return schedule_; }
  ImportanceMetric importance_metric() const { return importance_metric_; }

  // The milestones and recoveries so far, in the order in which they happened.
  const std::vector<MilestoneRecord>& milestones() const {
    return history_.milestones;
  }
  const std::vector<Recovery>& recoveries() const {
    return history_.recoveries;
  }
  const std::optional<ExposureChoice>& exposure_choice() const {
    return history_.exposure_choice;
  }

  // What has been learnt about the exposure of each photo, in the order of
  // their names; empty where it is not learnt.
  std::vector<PhotoExposure> Exposures() const;

  // Learns the exposure of each photo, or does not, as a search decided
  // (splat/search/exposure_search.h) and whatever the options say. Call it
  // before the first step. The choice becomes part of the history, so a
  // restored training keeps to it without another search.
  void SetExposureChoice(const ExposureChoice& choice);

  // Makes one gradient step, and then what the schedule says. Fails with
  // kUnusableResult when training diverges too often, when no Gaussian is left,
  // and at milestones when none is visible; with kBadInput when a photo has
  // become unreadable. A milestone renders every photo, which can take minutes.
  // So it may be cancelled, unlike the rest of the step; `cancellation` may be
  // null.
  StatusOr<StepReport> Step(const CancellationToken* cancellation = nullptr);

  // Makes the milestone that was cancelled after the last step, also after
  // Restore. Returns whether there was one. The next step would do so by
  // itself. kInterrupted when cancelled again, which changes nothing; else the
  // errors of Step.
  StatusOr<bool> FinishMilestone(const CancellationToken* cancellation);

  // For whoever ends a training before its last step. Colours are tested for
  // numbers that are not finite at some steps only. If model() has any now,
  // training goes back to its last good state. Returns whether it did. Fails
  // with kUnusableResult when training diverges too often, or has not begun.
  StatusOr<bool> GoBackUnlessFinite();

  // Save returns all that Restore needs to go on from here, in a trainer made
  // with the same arguments. Restore fails with kBadInput when the arrays of
  // the checkpoint do not fit together. CheckpointView is Save without a copy,
  // valid until the next step.
  TrainingCheckpointView CheckpointView();
  TrainingCheckpoint Save() const;
  Status Restore(TrainingCheckpoint checkpoint);

 private:
  StatusOr<float> GradientStep();
  float LossOfView(size_t view_index, int level);
  std::optional<std::string> FindTrouble(float loss);
  Status GoBack(const std::string& reason);
  Status FollowSchedule(const CancellationToken* cancellation);
  Status RunMilestone(TrainingEvent event,
                      const CancellationToken* cancellation);
  int64_t SimplificationBudget() const;
  void SortInSpace();  // See MortonOrder.
  void ClearCameras();
  void KeepAsGood();
  void Average();

  TrainerOptions options_;
  DensificationOptions densification_;  // Adapted to budget and method.
  TrainingSchedule schedule_;
  double scene_extent_;
  TrainingImages* images_;
  ThreadPool& pool_;
  ImportanceMetric importance_metric_;
  std::vector<ClearBall> clear_balls_;
  double decay_ = 0;  // Share of the opacity that is lost at a time.
  ViewOrder view_order_;

  int64_t iteration_ = 0;
  GaussianModel model_;
  Adam adam_;
  DensificationStatistics statistics_;
  LossMonitor loss_monitor_;
  TrainingHistory history_;  // Without `loss`, which is in loss_monitor_.

  // Scratch memory of a step.
  Rasterizer rasterizer_;
  PhotometricLoss loss_;
  RasterImages rendered_;
  ImageF target_;
  ImageF exposed_;  // As the photo's exposure shows what is rendered.
  std::vector<ColorSums> color_sums_;
  ImageF loss_gradient_;
  bool touched_finite_ = true;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_TRAIN_TRAINER_H_
