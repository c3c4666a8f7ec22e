// SPDX-License-Identifier: BSD-3-Clause
// How much memory the stages sfm and undistort are going to need.

#ifndef FREEGS_STAGES_SFM_SFM_MEMORY_H_
#define FREEGS_STAGES_SFM_SFM_MEMORY_H_

#include <cstdint>

#include "photos/photo_list.h"
#include "sfm/colmap/sfm_options.h"

namespace freegs::stages {

// Bytes of the largest process at the peak, for the usable photos of the list.
int64_t SfmMemory(const sfm::SfmOptions& options,
                  const photos::PhotoList& list,
                  int threads);
int64_t UndistortMemory(const photos::PhotoList& list, int cores);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SFM_SFM_MEMORY_H_
