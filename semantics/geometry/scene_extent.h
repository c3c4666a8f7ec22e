// SPDX-License-Identifier: BSD-3-Clause
// Where the subject of a scene is, and how large it is. The radius is the unit
// of most lengths in this library, so that options do not depend on the scale
// of the camera poses.

#ifndef FREEGS_SEMANTICS_GEOMETRY_SCENE_EXTENT_H_
#define FREEGS_SEMANTICS_GEOMETRY_SCENE_EXTENT_H_

#include <span>

#include <Eigen/Core>

#include "core/parallel.h"
#include "core/pinhole.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::semantics {

// The middle and the size of a scene, in the model frame
// (splat/scene/model_frame.h).
struct SceneExtent {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 1;  // > 0.
};

// Finds the extent from positions alone, N x 3: the centre is the median of
// each coordinate, the radius is the median distance from it. A few points far
// away do not matter, but a background of many points does.
SceneExtent ComputeSceneExtent(std::span<const float> positions);

// Finds the extent from what the photographs show. Thumbnails of at most 48
// views are rendered, and the points that are seen in the middle half of each
// are collected. The centre is the median of each coordinate; the radius is
// half the median depth, because photographers stand off a subject in
// proportion to its size. If there are no views, or they show nothing, the
// extent is taken from the positions of the Gaussians with at least
// min_opacity.
SceneExtent ComputeSceneExtent(const splat::GaussianModel& model,
                               std::span<const View> views,
                               double min_opacity,
                               ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_GEOMETRY_SCENE_EXTENT_H_
