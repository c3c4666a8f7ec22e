// SPDX-License-Identifier: BSD-3-Clause
// Start points for scenes whose cameras are known but whose points are not.

#ifndef FREEGS_SFM_SCENE_RANDOM_POINTS_H_
#define FREEGS_SFM_SCENE_RANDOM_POINTS_H_

#include <cstdint>
#include <vector>

#include "core/status.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// Where the cameras look: the point nearest to all their axes (least squares,
// held back towards the cameras where the axes are parallel), and the median
// distance of the cameras from it.
struct SceneFocus {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double distance = 1;
};
SceneFocus EstimateFocus(const Reconstruction& model);

// `count` grey points without tracks, ids from 1, that at least one camera
// sees. Even numbers: uniform in the ball around the focus with half its
// distance, where an object that was walked around lies. Odd numbers: at a
// random pixel of a random image, between 0.25 and 4 times the distance away,
// uniform in inverse depth, which covers the surroundings. A pure function of
// the model and the seed. kBadInput without images.
StatusOr<std::vector<Point3D>> RandomPoints(const Reconstruction& model,
                                            int count,
                                            uint64_t seed);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_RANDOM_POINTS_H_
