// SPDX-License-Identifier: BSD-3-Clause
// The colours of a model's points. COLMAP's mapper can find them, too, but
// decodes one photo after the other for it.

#ifndef FREEGS_SFM_FEATURES_POINT_COLORS_H_
#define FREEGS_SFM_FEATURES_POINT_COLORS_H_

#include "core/status.h"
#include "sfm/colmap/sfm_options.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// Gives each point the mean colour of the pixels that observe it. The model's
// images are photos of `input`. Returns kBadInput when one cannot be read, and
// kInterrupted. The result does not depend on the number of threads.
Status ColorPoints(const SfmInput& input,
                   int num_threads,
                   Reconstruction* model);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_FEATURES_POINT_COLORS_H_
