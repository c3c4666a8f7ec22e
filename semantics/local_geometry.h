// SPDX-License-Identifier: BSD-3-Clause
// What the neighbourhood of a point looks like.

#ifndef FREEGS_SEMANTICS_LOCAL_GEOMETRY_H_
#define FREEGS_SEMANTICS_LOCAL_GEOMETRY_H_

#include <span>
#include <vector>

#include "core/parallel.h"
#include "semantics/kd_tree.h"

namespace freegs::semantics {

// Means over the num_neighbors nearest points and the point itself.
struct LocalGeometry {
  std::vector<float> normals;   // N x 3, unit, of unknown sign: the direction
                                // of least spread of the neighbourhood.
  std::vector<float> flatness;  // N; 1 for a plane, 0 for a ball or a line:
                                // (middle - least) / largest eigenvalue.
  std::vector<float> spacing;   // N; distance to the last neighbour.
};

// tree: over N x 3 positions. Rows, not tree positions, index the results.
LocalGeometry ComputeLocalGeometry(const KdTree& tree,
                                   int num_neighbors,
                                   ThreadPool& pool);

// values: N x channels, by row. The mean over each point's num_neighbors
// nearest points in `tree` and itself: blurs texture, which otherwise tears
// textured objects apart in colour.
std::vector<float> SmoothOverNeighbors(const KdTree& tree,
                                       std::span<const float> values,
                                       int channels,
                                       int num_neighbors,
                                       ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOCAL_GEOMETRY_H_
