// SPDX-License-Identifier: BSD-3-Clause
// Points that two photos should both show and do not. In a model in which
// things that look alike were taken for one, photos of different places are
// claimed to look at the same points from nearly the same side, and share few
// of them (missing correspondences: Zach, Irschara and Bischof 2008; Wilson and
// Snavely 2013).

#ifndef FREEGS_SFM_LOOKALIKES_MISSING_CORRESPONDENCES_H_
#define FREEGS_SFM_LOOKALIKES_MISSING_CORRESPONDENCES_H_

#include <cstdint>
#include <vector>

#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// Two photos that are claimed to see points from similar sides and distances.
struct SharedView {
  uint32_t image_id1 = 0;  // Smaller than image_id2.
  uint32_t image_id2 = 0;
  double angle_deg = 0;  // Median angle between their rays to these points.

  // Points of one photo within sight of the other: the mean of both directions.
  double claimed = 0;
  double shared = 0;  // Of them, those that both observe.

  // How many more they would share if they were like other pairs at such
  // angles; not below 0.
  double missing = 0;
};

// For all pairs at less than 30 degrees that are claimed to share 20 points or
// more, by ascending ids. Which share of the points is usual is measured in the
// model itself: the median over pairs of similar angle, and at least what is
// usual at larger angles, because glued parts often bring pairs of very small
// angle. model must pass CheckReconstruction.
std::vector<SharedView> FindMissingCorrespondences(const Reconstruction& model);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_LOOKALIKES_MISSING_CORRESPONDENCES_H_
