// SPDX-License-Identifier: BSD-3-Clause
// What is known of an instance besides its Gaussians: position, boxes, score
// and names.

#ifndef FREEGS_SEMANTICS_INSTANCES_INSTANCES_H_
#define FREEGS_SEMANTICS_INSTANCES_INSTANCES_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/parallel.h"
#include "core/pinhole.h"
#include "semantics/geometry/boxes.h"
#include "semantics/geometry/plane.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::semantics {

// BuildInstances returns lengths and positions in the model frame
// (splat/scene/model_frame.h). In files they are in the world frame of the
// camera poses, and InWorld (stages/scene/working_frame.h) converts.
struct Instance {
  int id = 0;  // Label + 1. In images of ids, 0 means no instance.
  int64_t num_gaussians = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // Mean by opacity.
  AxisAlignedBox aabb;
  OrientedBox obb;
  // 0 .. 1: how likely it is one whole thing (evidence_clustering.h), or the
  // mean membership probability of its Gaussians (union_clustering.h).
  double score = 0;
  bool background = false;         // True for a large plane of the scene.
  std::vector<std::string> words;  // Names, the best first.
};

struct InstanceBoxOptions {
  // Gaussians of less opacity do not count for boxes.
  double min_opacity = 0.1;

  // A Gaussian is a stray, and does not count, if its 8th nearest neighbour in
  // the instance is farther away than this many times the median.
  double max_isolation = 4;

  // The share of the opacity that may lie outside of a box on each side. A
  // Gaussian ends one standard deviation from its centre.
  double trim = 0.005;
};

// Returns one instance per label 0 .. num_labels - 1, with everything but the
// words.
//
// labels: for each Gaussian, -1 for none. scores, background: per label, or
// empty. vertical: a unit vector. With it the oriented box stands upright, and
// its base is the rectangle of least area, found in steps of one degree.
// Without it the sides of the box are the principal axes of the Gaussians.
std::vector<Instance> BuildInstances(
    const splat::GaussianModel& model,
    std::span<const int32_t> labels,
    int num_labels,
    std::span<const double> scores,
    std::span<const uint8_t> background,
    const std::optional<Eigen::Vector3d>& vertical,
    const InstanceBoxOptions& options,
    ThreadPool& pool);

// Bends an upward direction until it is at right angles to the x axes of the
// cameras, as far as these point in different directions: people hold cameras
// level, wherever they look. Cameras whose x axes rise by 30 degrees or more
// are left out: they were held on their side.
Eigen::Vector3d BentToLevelCameras(std::span<const View> views,
                                   const Eigen::Vector3d& up);

// Returns the upward direction of the scene. The mean of the cameras' own
// upward directions gives a first one. It leans where they look down from one
// side only, so it is bent (BentToLevelCameras). If the normal of a plane is
// within 30 degrees of it (floor or table top; the first such plane in
// `planes`), the normal is taken, since it is more exact. Nothing if the
// cameras point in all directions.
std::optional<Eigen::Vector3d> EstimateVertical(std::span<const View> views,
                                                std::span<const Plane> planes);

// The vertical along which the oriented boxes of instances were made. It knows
// the planes of the scene, which the views alone do not. Without instances, or
// if their boxes lean by 30 degrees or more, it is that of the views. The axes
// of both must be the same, but not the origin or the unit.
std::optional<Eigen::Vector3d> VerticalOfBoxes(
    std::span<const View> views, std::span<const Instance> instances);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_INSTANCES_H_
