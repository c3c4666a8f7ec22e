// SPDX-License-Identifier: BSD-3-Clause
// Measures how well the points of a reconstruction fit the photos that see
// them.

#ifndef FREEGS_SFM_SCENE_RECONSTRUCTION_MEASURES_H_
#define FREEGS_SFM_SCENE_RECONSTRUCTION_MEASURES_H_

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// The largest angle, in degrees, between the rays from a point to the centres
// of the cameras that see it. Of more than 256 cameras, 256 that are spread
// evenly over the list stand for all.
double TriangulationAngleDeg(const Eigen::Vector3d& point,
                             const std::vector<Eigen::Vector3d>& centres);

// Figures over all points of a reconstruction; 0 where there is nothing to
// measure.
struct ReconstructionMeasures {
  // The mean distance in pixels between a feature and the projection of its
  // point, over all observations whose point lies in front of the camera. It is
  // computed from poses, points and cameras; the errors stored with the points
  // are not used.
  double mean_reprojection_error_px = 0;

  // Medians over the points with two observations or more: of the number of
  // observations, and of the largest angle between rays in degrees (see
  // TriangulationAngleDeg).
  double median_track_length = 0;
  double median_triangulation_deg = 0;

  size_t num_points = 0;
  size_t observations = 0;  // Those of points in front of the camera.

  // Observations of points that the camera cannot see where it is, because they
  // lie behind it. They have no reprojection error.
  size_t behind = 0;
};

// Measures all points of a model whose images have their cameras. Observations
// in images, or of features, that the model lacks are left out.
ReconstructionMeasures MeasureReconstruction(const Reconstruction& model);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_RECONSTRUCTION_MEASURES_H_
