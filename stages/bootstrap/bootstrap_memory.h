// SPDX-License-Identifier: BSD-3-Clause
// How much memory stage bootstrap is going to need.

#ifndef FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_MEMORY_H_
#define FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_MEMORY_H_

#include <cstdint>

#include "stages/bootstrap/bootstrap_options.h"

namespace freegs::stages {

struct BootstrapSize {
  // Pixels of all views that teach, at the size of their blending weights; of
  // one view at the size at which patches are compared; of one photo.
  int64_t weight_pixels = 0;
  int64_t patch_pixels = 0;
  int64_t photo_pixels = 0;

  int64_t gaussians = 0;
  int64_t model_bytes = 0;  // Of the CLIP model's files.
  int threads = 1;
};

// Bytes at the peak.
int64_t BootstrapMemory(const BootstrapStageOptions& options,
                        const BootstrapSize& size);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_MEMORY_H_
