// SPDX-License-Identifier: BSD-3-Clause
// A reconstruction as the splat renderer wants it: posed pinhole cameras.

#ifndef FREEGS_SFM_SCENE_VIEWS_H_
#define FREEGS_SFM_SCENE_VIEWS_H_

#include <vector>

#include "core/pinhole.h"
#include "core/status.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// The images of a consistent model (see ReadModel) by ascending name. kBadInput
// when a camera has lens distortion.
StatusOr<std::vector<View>> MakeViews(const Reconstruction& model);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_VIEWS_H_
