// SPDX-License-Identifier: BSD-3-Clause
// Phase 1: fits Gaussians to posed photographs.

#ifndef FREEGS_SPLAT_TRAINER_H_
#define FREEGS_SPLAT_TRAINER_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"
#include "splat/adam.h"
#include "splat/checkpoint.h"
#include "splat/densification.h"
#include "splat/gaussian_model.h"
#include "splat/learning_rates.h"
#include "splat/loss.h"
#include "splat/rasterizer.h"
#include "splat/renderer.h"
#include "splat/training_images.h"

namespace freegs::splat {

struct TrainerOptions {
  // Gradient steps, one view each.
  int iterations = 7000;

  // Highest SH degree of the result, and the share of the iterations after
  // which each further degree is switched on (3DGS: 1000 of 30000).
  int sh_degree = 3;
  double sh_degree_interval = 1.0 / 30;

  // Shares of the iterations at which the image resolution doubles: training
  // starts at level resolution_steps.size() of the image pyramid. Coarse images
  // cost less and carry what the first, blurry model can learn.
  std::vector<double> resolution_steps = {0.1, 0.3};

  // Densification starts and stops at these shares of the iterations, every
  // densify_interval iterations. 0 as interval keeps the initial points.
  double densify_start = 0.05;
  double densify_stop = 0.5;
  int densify_interval = 100;

  // Opacities are set to at most 0.01 every so many iterations while
  // densifying; 0 never does. (3DGS does, Mini-Splatting does not.)
  int opacity_reset_interval = 0;

  DensificationOptions densification;
  LearningRateOptions learning_rates;
  PhotometricLossOptions loss;
  RenderOptions render;
  uint64_t seed = 0;

  Status Check() const;
};

// The result of one step.
struct StepReport {
  int64_t iteration = 0;  // Counted from 1.
  float loss = 0;
  size_t num_gaussians = 0;
};

// Usage:
//   Trainer trainer(options, initial_model, extent, &images, &pool);
//   while (!trainer.done()) { trainer.Step(); ... }
//   WritePly(path, trainer.model());
// The state after k steps depends on the inputs, options and seed only: not on
// the number of threads, nor on having been saved and restored in between.
class Trainer {
 public:
  // `images` and `pool` must outlive the trainer. scene_extent in world units,
  // see SceneExtent. The options must pass Check().
  Trainer(const TrainerOptions& options,
          GaussianModel initial_model,
          double scene_extent,
          TrainingImages* images,
          ThreadPool* pool);

  bool done() const { return iteration_ >= options_.iterations; }
  int64_t iteration() const { return iteration_; }
  const GaussianModel& model() const { return model_; }

  // One gradient step, and densification when it is due. kUnusableResult when
  // the numbers have diverged, kBadInput when a photo has become unreadable.
  StatusOr<StepReport> Step();

  // Everything needed to go on later. Restore refuses a checkpoint whose arrays
  // do not fit together.
  TrainingCheckpoint Save() const;
  Status Restore(TrainingCheckpoint checkpoint);

 private:
  size_t ViewOfIteration(int64_t iteration);
  int LevelOfIteration(int64_t iteration) const;
  int ShDegreeOfIteration(int64_t iteration) const;
  void CollectTouched();
  void MaybeDensify();

  TrainerOptions options_;
  double scene_extent_;
  TrainingImages* images_;
  ThreadPool* pool_;

  int64_t iteration_ = 0;
  GaussianModel model_;
  Adam adam_;
  DensificationStatistics statistics_;

  // Scratch of a step.
  Rasterizer rasterizer_;
  PhotometricLoss loss_;
  RasterImages rendered_;
  ImageF target_;
  ImageF loss_gradient_;
  GaussianGradients gradients_;
  std::vector<uint8_t> touched_flags_;
  std::vector<uint32_t> touched_;
  std::vector<float> radii_;
  int64_t epoch_ = -1;
  std::vector<uint32_t> epoch_order_;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_TRAINER_H_
