// SPDX-License-Identifier: BSD-3-Clause
// What the neighbourhood of a point looks like.

#ifndef FREEGS_SEMANTICS_GEOMETRY_LOCAL_GEOMETRY_H_
#define FREEGS_SEMANTICS_GEOMETRY_LOCAL_GEOMETRY_H_

#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/kd_tree.h"

namespace freegs::semantics {

// tree: over N x 3 positions. The unit normal at each point, N x 3 by row (not
// by tree position), of unknown sign: the direction of least spread of its
// num_neighbors nearest points and itself.
std::vector<float> ComputeNormals(const KdTree& tree,
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

#endif  // FREEGS_SEMANTICS_GEOMETRY_LOCAL_GEOMETRY_H_
