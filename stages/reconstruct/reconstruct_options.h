// SPDX-License-Identifier: BSD-3-Clause
// The options of reconstruct, and what they mean to the trainer.

#ifndef FREEGS_STAGES_RECONSTRUCT_RECONSTRUCT_OPTIONS_H_
#define FREEGS_STAGES_RECONSTRUCT_RECONSTRUCT_OPTIONS_H_

#include <cstdint>
#include <string>

#include "core/status.h"
#include "pipeline/option_table.h"
#include "splat/render/renderer.h"
#include "splat/train/trainer.h"

namespace freegs::stages {

struct ReconstructStageOptions {
  int iterations = 5000;
  // Longest side in pixels of the images the splats learn from; 0 keeps the
  // photos' own size.
  int max_image_size = 800;
  int sh_degree = 3;
  // mini_splatting, gradient or none.
  std::string densification = "mini_splatting";
  // Upper bound of the number of Gaussians of the result, "auto" or a number; 0
  // is none.
  std::string budget = "auto";
  // The most that "auto" considers.
  int budget_limit = 100000;
  // Whether Mini-Splatting starts again from depth maps: auto, always, never.
  std::string depth_reinit = "auto";
  // How Mini-Splatting measures importance: auto, indoor or outdoor.
  std::string importance = "auto";
  // Iterations between densifications; 0 never densifies.
  int densify_interval = 100;
  double densify_gradient = 2e-4;
  // For densification = gradient only.
  int opacity_reset_interval = 0;
  bool coarse_to_fine = true;
  std::string background = "black";
  // Iterations between measurements on the holdout photos; 0: only at the end.
  int holdout_interval = 1000;
  // Memory for decoded photos.
  double image_cache_gb = 4;
  // A .ply to take instead of training.
  std::string import;
};

void RegisterReconstructOptions(ReconstructStageOptions& options,
                                pipeline::OptionTable& table);

// How pictures of the scene are rendered.
splat::RenderOptions ReconstructRenderOptions(
    const ReconstructStageOptions& options);

// kInvalidArgument, naming the option, when a value makes no sense.
StatusOr<splat::TrainerOptions> MakeTrainerOptions(
    const ReconstructStageOptions& options, uint64_t seed);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RECONSTRUCT_RECONSTRUCT_OPTIONS_H_
