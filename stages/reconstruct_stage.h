// SPDX-License-Identifier: BSD-3-Clause
// undistort/ -> reconstruct/: phase 1, a Gaussian scene from posed photos.

#ifndef FREEGS_STAGES_RECONSTRUCT_STAGE_H_
#define FREEGS_STAGES_RECONSTRUCT_STAGE_H_

#include <cstdint>
#include <memory>
#include <string>

#include "pipeline/option_table.h"
#include "pipeline/stage.h"

namespace freegs::stages {

struct ReconstructStageOptions {
  int iterations = 5000;
  // Longest side in pixels of the images the splats learn from; 0 keeps the
  // photos' own size.
  int max_image_size = 800;
  int sh_degree = 3;
  // Upper bound of the number of Gaussians; 0 is none.
  int max_gaussians = 100000;
  // Iterations between densifications; 0 never densifies.
  int densify_interval = 100;
  double densify_gradient = 3e-4;
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

std::unique_ptr<pipeline::Stage> MakeReconstructStage(
    const ReconstructStageOptions& options, uint64_t seed);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RECONSTRUCT_STAGE_H_
