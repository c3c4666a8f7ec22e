// SPDX-License-Identifier: BSD-3-Clause
// Where the subject of a scene is, and how large.

#ifndef FREEGS_SEMANTICS_GEOMETRY_SCENE_EXTENT_H_
#define FREEGS_SEMANTICS_GEOMETRY_SCENE_EXTENT_H_

#include <span>

#include <Eigen/Core>

#include "core/parallel.h"
#include "core/pinhole.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::semantics {

struct SceneExtent {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  // World frame.
  double radius = 1;                                 // World units; > 0.
};

// From positions alone, N x 3: their per-axis median, and the median distance
// from it. Far Gaussians do not matter, but a background of many does.
SceneExtent ComputeSceneExtent(std::span<const float> positions);

// From what the photographs show: the points seen in the middle half of the
// pictures (a few thumbnails are rendered). Their per-axis median, and half the
// median depth at which they are seen: photographers stand off a subject in
// proportion to its size, whatever surrounds it. Without views, or when they
// show nothing, from the positions of Gaussians of at least min_opacity.
SceneExtent ComputeSceneExtent(const splat::GaussianModel& model,
                               std::span<const View> views,
                               double min_opacity,
                               ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_GEOMETRY_SCENE_EXTENT_H_
