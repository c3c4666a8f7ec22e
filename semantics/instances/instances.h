// SPDX-License-Identifier: BSD-3-Clause
// Instances: what a set of Gaussians with one label amounts to.

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
#include "semantics/geometry/planes.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::semantics {

// Everything in the world frame of the camera poses, in its units.
struct Instance {
  int id = 0;  // 1, 2, ... = label + 1; 0 in images means no instance.
  int64_t num_gaussians = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // Opacity-weighted mean.
  AxisAlignedBox aabb;
  OrientedBox obb;
  double score = 0;         // How firmly its Gaussians belong to it, 0 .. 1.
  bool background = false;  // One of the scene's large planes.
  std::vector<std::string> words;  // What it is called, best first.
};

struct InstanceBoxOptions {
  // Gaussians fainter than this do not count for boxes.
  double min_opacity = 0.1;

  // Gaussians whose 8th nearest neighbour in the instance is farther away than
  // this many times the median are strays and do not count.
  double max_isolation = 4;

  // Share of the opacity that may lie outside on each side of a box, where a
  // Gaussian ends one standard deviation from its centre.
  double trim = 0.005;
};

// One instance per label 0 .. num_labels - 1, boxes and all but the words.
// labels: per Gaussian, -1 for none. scores, background: per label, may be
// empty. With a vertical (unit vector) the oriented box stands upright and its
// base is the rectangle of least area, found in steps of one degree; without,
// its sides are the principal axes.
std::vector<Instance> BuildInstances(
    const splat::GaussianModel& model,
    std::span<const int32_t> labels,
    int num_labels,
    std::span<const double> scores,
    std::span<const uint8_t> background,
    const std::optional<Eigen::Vector3d>& vertical,
    const InstanceBoxOptions& options,
    ThreadPool& pool);

// The upward direction of the scene: photographers hold cameras upright on
// average, and the normal of a large plane within 30 degrees of that (floor,
// table top; `planes` by descending size) is more exact. Nothing when the
// cameras point all ways.
std::optional<Eigen::Vector3d> EstimateVertical(std::span<const View> views,
                                                std::span<const Plane> planes);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_INSTANCES_H_
