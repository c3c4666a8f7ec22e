// SPDX-License-Identifier: BSD-3-Clause
// Finds the large planes of a scene: floor, walls and table tops. They are
// taken out before objects are clustered, because the objects that stand on a
// plane would be joined through it.
//
//   const KdTree tree = ...;  // Over the positions, N x 3.
//   const std::vector<float> normals = ComputeNormals(tree, 24, pool);
//   const PlaneSegmentation planes = FindPlanes(
//       positions, normals, extent.radius, PlaneOptions(), seed, pool);
//   // planes.plane_index[i] is the plane of point i, or -1.

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
  // The largest number of planes. 0 finds none.
  int max_planes = 8;

  // The shorter side of a plane is at least this long, in scene radii (see
  // SceneExtent). Smaller faces belong to objects.
  double min_width = 1;

  // The points of a plane lie at most this far from it, in scene radii. Where
  // the points lie closer to the plane, the distance is chosen smaller.
  double max_distance = 0.03;

  Status Check() const;
};

// The plane of the points x with normal . x = offset, in world units. |normal|
// = 1.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 0;
  // Points up to this far from the plane belong to it. The points of a parallel
  // sheet that was joined to the plane may be farther away.
  double distance = 0;

  double SignedDistance(const Eigen::Vector3d& x) const {
    return normal.dot(x) - offset;
  }
};

struct PlaneSegmentation {
  std::vector<Plane> planes;         // In the order in which they were found.
  std::vector<int32_t> plane_index;  // N; -1 for a point in no plane.
};

// positions, normals: N x 3; the normals have length 1 and any sign (see
// ComputeNormals). scene_radius: in the units of the positions.
//
// Planes are found one after another by RANSAC (Fischler and Bolles 1981). A
// single point and its normal make a candidate. The candidate with the most
// points that lie near it and have its normal is fitted by least squares. Its
// large connected parts become a plane and are taken out of the search. At the
// end, planes that are parallel within 15 degrees and lie on top of each other
// are joined: they are sheets of one thick or bumpy surface. The result depends
// on the input and the seed only, not on the number of threads.
PlaneSegmentation FindPlanes(std::span<const float> positions,
                             std::span<const float> normals,
                             double scene_radius,
                             const PlaneOptions& options,
                             uint64_t seed,
                             ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_GEOMETRY_PLANES_H_
