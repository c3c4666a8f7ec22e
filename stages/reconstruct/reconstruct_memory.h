// SPDX-License-Identifier: BSD-3-Clause
// How much memory stage reconstruct is going to need.

#ifndef FREEGS_STAGES_RECONSTRUCT_RECONSTRUCT_MEMORY_H_
#define FREEGS_STAGES_RECONSTRUCT_RECONSTRUCT_MEMORY_H_

#include <cstdint>
#include <optional>

#include "splat/train/trainer.h"
#include "stages/reconstruct/reconstruct_options.h"

namespace freegs::stages {

struct ReconstructSize {
  // Pixels at the size of training: of all training photos, of all holdout
  // photos, of the largest view.
  int64_t train_pixels = 0;
  int64_t holdout_pixels = 0;
  int64_t view_pixels = 0;

  int64_t photo_pixels = 0;        // Of the largest photo at its own size.
  bool masks = false;              // Whether photos have masks.
  int64_t points = 0;              // Where training begins.
  int64_t imported_gaussians = 0;  // With reconstruct.import.
  int threads = 1;
};

// The most Gaussians that training is expected to have at any time. Nothing
// when no option bounds them.
std::optional<double> ExpectedGaussians(const ReconstructStageOptions& options,
                                        const splat::TrainerOptions& training,
                                        const ReconstructSize& size);

// Bytes at the peak; 0 when the number of Gaussians has no bound.
int64_t ReconstructMemory(const ReconstructStageOptions& options,
                          const splat::TrainerOptions& training,
                          const ReconstructSize& size);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RECONSTRUCT_RECONSTRUCT_MEMORY_H_
