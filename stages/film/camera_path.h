// SPDX-License-Identifier: BSD-3-Clause
// Paths of a moving camera: a smooth one through given poses, and an orbit
// around a point.

#ifndef FREEGS_STAGES_FILM_CAMERA_PATH_H_
#define FREEGS_STAGES_FILM_CAMERA_PATH_H_

#include <numbers>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/rigid3d.h"

namespace freegs::stages {

struct SmoothPathOptions {
  int num_frames = 300;

  // So many times every pose but the first and the last becomes half of itself
  // and a quarter of each neighbour. A hand that takes photos shakes.
  int smoothing = 0;

  // Moving by this length counts as much as turning by one radian. For a
  // picture of things at this depth, both move it by as many pixels.
  double depth = 5;
};

// Returns cam_from_world of num_frames frames. The path begins at the first
// pose, ends at the last and goes through (with smoothing: near) those between.
// It is smooth, and its speed, as `depth` measures it, is constant: from frame
// to frame the picture changes by the same amount, wherever the poses lie close
// together. A single pose, or several equal ones, gives a camera that stands
// still; no pose gives no frame.
std::vector<Rigid3d> SmoothPath(std::span<const Rigid3d> poses,
                                const SmoothPathOptions& options);

// A circle, or a part of it, of a camera that looks at a point.
struct Orbit {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // What it looks at.
  Eigen::Vector3d up = -Eigen::Vector3d::UnitY();    // A unit vector.
  double radius = 1;  // Distance from the line through the centre along `up`.
  double height = 0;  // Along `up`, from the centre.

  // The azimuth in radians counts from OrbitAxes(up).col(0) towards its col(1),
  // anticlockwise as seen from above. Where `arc` is less than a full turn, the
  // camera swings to and fro between first_azimuth and first_azimuth + arc.
  double first_azimuth = 0;
  double arc = 2 * std::numbers::pi;
};

// Two directions at right angles to `up` and to each other, and `up`, as the
// columns of a rotation matrix.
Eigen::Matrix3d OrbitAxes(const Eigen::Vector3d& up);

// cam_from_world of the camera at this azimuth, level, with the centre in the
// middle of its picture.
Rigid3d OrbitPose(const Orbit& orbit, double azimuth);

// Returns cam_from_world of num_frames frames. The path is closed: after the
// last frame comes the first. A full turn has constant speed; a swing slows
// down at its ends.
std::vector<Rigid3d> OrbitPath(const Orbit& orbit, int num_frames);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_FILM_CAMERA_PATH_H_
