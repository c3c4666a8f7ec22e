// SPDX-License-Identifier: BSD-3-Clause
// Finds points that two photos should both show, by their poses in the model,
// and do not. If things that look alike were taken for one thing, the model
// says that photos of two different places look at the same points from nearly
// the same side; yet they share few of these points. Method: missing
// correspondences of Zach, Irschara and Bischof (2008), also used by Wilson and
// Snavely (2013).

#ifndef FREEGS_SFM_LOOKALIKES_MISSING_CORRESPONDENCES_H_
#define FREEGS_SFM_LOOKALIKES_MISSING_CORRESPONDENCES_H_

#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// Two photos that see the same points from similar sides and distances,
// according to the model.
struct SharedView {
  uint32_t image_id1 = 0;  // Smaller than image_id2.
  uint32_t image_id2 = 0;
  double angle_deg = 0;  // Median angle between their rays to these points.

  // How many points of one photo project into the other one; the mean over
  // both directions. Photos with many points are sampled, so this need not be a
  // whole number.
  double claimed = 0;
  double shared = 0;  // How many of these both photos observe.

  // By how many points `shared` falls short of what is usual in this model for
  // pairs at such an angle; 0 if it does not.
  double missing = 0;
};

// Examines the pairs of photos in `compared` (ids, the smaller one first):
// those whose features were compared with each other. A pair that was not
// compared shares few points even where the model is right. Returns the pairs
// whose rays meet at less than 30 degrees and that should share at least 20
// points, by ascending ids.
//
// The share of points that is usual is measured in the model itself: it is the
// median over the pairs of similar angle, or the usual share at larger angles
// if that is higher. Parts that were glued together often bring many pairs of
// very small angle, which would otherwise pull the median down.
//
// The model must pass CheckReconstruction.
std::vector<SharedView> FindMissingCorrespondences(
    const Reconstruction& model,
    const std::set<std::pair<uint32_t, uint32_t>>& compared);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_LOOKALIKES_MISSING_CORRESPONDENCES_H_
