// SPDX-License-Identifier: BSD-3-Clause
// Converts a reconstruction to posed pinhole cameras for the splat renderer.

#ifndef FREEGS_SFM_SCENE_VIEWS_H_
#define FREEGS_SFM_SCENE_VIEWS_H_

#include <vector>

#include "core/pinhole.h"
#include "core/status.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// The camera without its lens distortion; lengths are in pixels. The sides of
// its image must fit an int, as they do after CheckReconstruction.
Pinhole PinholeOf(const Camera& camera);

// Returns the images of the model in the order of their names (NaturalLess).
// The model must pass CheckReconstruction. Returns kBadInput when a camera has
// lens distortion.
StatusOr<std::vector<View>> MakeViews(const Reconstruction& model);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_VIEWS_H_
