// SPDX-License-Identifier: BSD-3-Clause
// Removes from a reconstruction what does not fit it.

#ifndef FREEGS_SFM_SCENE_TRACK_FILTER_H_
#define FREEGS_SFM_SCENE_TRACK_FILTER_H_

#include <cstddef>

#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

struct TrackFilter {
  double max_error_px = 4.0;  // COLMAP's threshold.
  double min_angle_deg = 1.5;
};

// Removes observations that fail to project or lie too far off, then points
// with fewer than two observations or too small an angle between their rays;
// sets the others' errors. Returns the number of observations removed. model
// must pass CheckReconstruction and have no dangling references.
size_t FilterTracks(const TrackFilter& filter, Reconstruction* model);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_TRACK_FILTER_H_
