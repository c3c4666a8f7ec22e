// SPDX-License-Identifier: BSD-3-Clause
// Makes start points for scenes whose cameras are known but whose points are
// not.

#ifndef FREEGS_SFM_SCENE_RANDOM_POINTS_H_
#define FREEGS_SFM_SCENE_RANDOM_POINTS_H_

#include <cstdint>
#include <vector>

#include "core/status.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// The point that the cameras look at, and the median distance of the cameras
// from it. The point is the nearest to all viewing axes by least squares. A
// weak pull towards the cameras determines it where the axes are parallel.
struct SceneFocus {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double distance = 1;
};
SceneFocus EstimateFocus(const Reconstruction& model);

// Returns `count` grey points without tracks, with ids from 1. Half of them are
// uniform in a ball around the focus, as far as a camera sees it. The radius of
// the ball is half the distance of the cameras: there lies an object that
// somebody walked around. The other half covers the surroundings: each lies
// behind a random pixel of a random image, 0.25 to 4 times that distance away,
// uniform in inverse depth. Lens distortion is left out there, so some of these
// points may lie just outside of what the cameras see. If no camera sees the
// ball, all points are of the second kind. The result depends on the model and
// the seed only.
// Returns kBadInput when the model has no images.
StatusOr<std::vector<Point3D>> RandomPoints(const Reconstruction& model,
                                            int count,
                                            uint64_t seed);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_RANDOM_POINTS_H_
