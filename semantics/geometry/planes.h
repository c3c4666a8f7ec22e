// SPDX-License-Identifier: BSD-3-Clause
// Finds the large planes of a scene: floor, walls, table tops. Objects stand on
// them and would be joined through them.

#ifndef FREEGS_SEMANTICS_GEOMETRY_PLANES_H_
#define FREEGS_SEMANTICS_GEOMETRY_PLANES_H_

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

struct PlaneOptions {
  // At most this many planes; 0 finds none.
  int max_planes = 8;

  // A plane's shorter side is at least this many times the scene radius (see
  // SceneExtent), so that faces of objects are not taken for background.
  double min_width = 1;

  // Farthest distance of a plane's points from it, in scene radii. The distance
  // used is smaller where the points lie closer.
  double max_distance = 0.03;

  Status Check() const;
};

// n . x = offset, |n| = 1.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 0;
  double distance = 0;  // Points up to here belong to it, world units; sheets
                        // that joined it may be farther.

  double SignedDistance(const Eigen::Vector3d& x) const {
    return normal.dot(x) - offset;
  }
};

struct PlaneSegmentation {
  std::vector<Plane> planes;         // In the order found: largest first.
  std::vector<int32_t> plane_index;  // N; -1 where none.
};

// positions, normals: N x 3, normals unit and of any sign (see
// ComputeNormals). Greedy RANSAC (Fischler and Bolles 1981) in which a single
// point and the normal of its neighbourhood make a candidate; the one with most
// points near it and normals along it is refined by least squares, cut to its
// large connected parts, and taken out. Same seed, same result.
PlaneSegmentation FindPlanes(std::span<const float> positions,
                             std::span<const float> normals,
                             double scene_radius,
                             const PlaneOptions& options,
                             uint64_t seed,
                             ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_GEOMETRY_PLANES_H_
