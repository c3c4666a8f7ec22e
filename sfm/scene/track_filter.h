// SPDX-License-Identifier: BSD-3-Clause
// Removes observations and points that do not fit a reconstruction.

#ifndef FREEGS_SFM_SCENE_TRACK_FILTER_H_
#define FREEGS_SFM_SCENE_TRACK_FILTER_H_

#include <cstddef>

#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// Removes observations whose point lies behind the camera or projects more than
// 4 pixels (COLMAP's threshold) from the feature. Then removes points that have
// fewer than two observations left, or whose rays differ by less than 1.5
// degrees, and sets `error` of the points that stay. Returns how many
// observations were removed. `model` must pass CheckReconstruction and must
// have no dangling references (see RemoveDanglingReferences).
size_t FilterTracks(Reconstruction* model);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_TRACK_FILTER_H_
