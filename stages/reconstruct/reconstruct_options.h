// SPDX-License-Identifier: BSD-3-Clause
// The options of stage reconstruct, and how the trainer is told them.

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
  int iterations = 2500;
  // Longest side in pixels of the images that training sees; 0 keeps the
  // photos' own size.
  int max_image_size = 800;
  int sh_degree = 2;
  // mini_splatting, gradient or none.
  std::string densification = "mini_splatting";
  // Upper bound of the number of Gaussians of the result: a number, where 0 is
  // no bound, "auto", see AutomaticBudget, or "auto:N", at most N of that.
  std::string budget = "auto";
  // Iterations between densifications; 0 never densifies.
  int densify_interval = 75;
  // A Gaussian whose mean gradient in the image (which spans -1 to 1) is larger
  // is cloned or split.
  double densify_gradient = 2e-4;
  // Whether the exposure of each photo is learnt: auto, on or off. auto asks
  // a short training (splat/search/exposure_search.h).
  std::string exposure = "auto";
  std::string background = "black";  // black or white.
  // Whether the model is to be rendered with Mip-Splatting's 2D filter.
  bool antialiased = false;
  // Iterations between measurements on the holdout photos; 0 measures only at
  // the end. Users cannot set this; tests do.
  int holdout_interval = 1000;
  // Memory for decoded photos, in 1e9 bytes.
  double image_cache_gb = 4;
  // A .ply file to take instead of training; empty trains.
  std::string import;
};

// Adds section [reconstruct] to the table, which keeps pointers to `options`.
void RegisterReconstructOptions(ReconstructStageOptions& options,
                                pipeline::OptionTable& table);

// The background as the renderer takes it.
splat::RenderOptions ReconstructRenderOptions(
    const ReconstructStageOptions& options);

// The budget for training photos with so many pixels together, at the size of
// training, on a machine with so much memory: what the photos can determine,
// and no more than would fill half of the memory. A memory of 0 is not known,
// and bounds nothing.
int64_t AutomaticBudget(int64_t train_pixels, int64_t memory_bytes);

// Translates the options for the trainer. train_pixels and memory_bytes are
// those of AutomaticBudget. kInvalidArgument, naming the option, for a value
// that is not allowed.
StatusOr<splat::TrainerOptions> MakeTrainerOptions(
    const ReconstructStageOptions& options,
    int64_t train_pixels,
    int64_t memory_bytes,
    uint64_t seed);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RECONSTRUCT_RECONSTRUCT_OPTIONS_H_
