// SPDX-License-Identifier: BSD-3-Clause
// How well the points of a reconstruction fit the photos that see them.

#ifndef FREEGS_SFM_SCENE_RECONSTRUCTION_MEASURES_H_
#define FREEGS_SFM_SCENE_RECONSTRUCTION_MEASURES_H_

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// The largest angle, in degrees, between the rays from a point to the centres
// of the cameras that see it.
double TriangulationAngleDeg(const Eigen::Vector3d& point,
                             const std::vector<Eigen::Vector3d>& centres);

// Figures over all points of a reconstruction; 0 where there is nothing to
// measure.
struct ReconstructionMeasures {
  // Distance in pixels between an observation and its projected point, mean
  // over all observations of points by registered photos. It is computed from
  // poses, points and camera models, not read from the model's files.
  double mean_reprojection_error_px = 0;

  // Observations per point, and the largest angle between a point's rays
  // (see TriangulationAngleDeg); medians over points with two observations or
  // more.
  double median_track_length = 0;
  double median_triangulation_deg = 0;

  size_t num_points = 0;
  size_t observations = 0;  // Those in front of their camera.
};

ReconstructionMeasures MeasureReconstruction(const Reconstruction& model);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_RECONSTRUCTION_MEASURES_H_
