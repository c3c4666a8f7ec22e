// SPDX-License-Identifier: BSD-3-Clause
// What two photos see of the same things: rays that meet, and pixels that a
// homography maps onto each other.

#ifndef FREEGS_SFM_SCENE_TWO_VIEWS_H_
#define FREEGS_SFM_SCENE_TWO_VIEWS_H_

#include <Eigen/Core>

namespace freegs::sfm {

// The angle between two vectors, in degrees from 0 to 180; also of tiny ones.
double RayAngleDeg(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

// How far along two rays the place lies where they come nearest to each other,
// both times the same positive factor. Negative: behind the camera.
struct RayDepths {
  double depth1 = 0;
  double depth2 = 0;
};

// Both rays and `t` are in the frame of the second camera: `ray1` begins at
// `t`, where the first camera is, and `ray2` at the origin. The rays need no
// unit length.
RayDepths FindRayDepths(const Eigen::Vector3d& ray1,
                        const Eigen::Vector3d& ray2,
                        const Eigen::Vector3d& t);

// The share of matches that a homography explains: it maps the pixel in the
// first photo to within 4 pixels of that in the second one, as COLMAP asks in
// its search for a homography. Column i of both has match i; 0 of no matches.
double ShareExplained(const Eigen::Matrix3d& homography,
                      const Eigen::Matrix2Xd& pixels1,
                      const Eigen::Matrix2Xd& pixels2);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_TWO_VIEWS_H_
