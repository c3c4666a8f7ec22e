// SPDX-License-Identifier: BSD-3-Clause
// Properties of a point that its nearest neighbours tell: the normal of the
// surface, and mean values.

#ifndef FREEGS_SEMANTICS_GEOMETRY_LOCAL_GEOMETRY_H_
#define FREEGS_SEMANTICS_GEOMETRY_LOCAL_GEOMETRY_H_

#include <span>
#include <vector>

#include "core/kd_tree.h"
#include "core/parallel.h"

namespace freegs::semantics {

// Returns a unit normal for each of N points, N x 3 in the order of rows (not
// of tree positions). A normal is the direction in which the point and its
// num_neighbors nearest neighbours spread least; its sign means nothing. `tree`
// holds positions, N x 3.
std::vector<float> ComputeNormals(const KdTree& tree,
                                  int num_neighbors,
                                  ThreadPool& pool);

// Returns, for each of N points, the mean of `values` over the point and its
// num_neighbors nearest neighbours in `tree`. values: N x channels in the order
// of rows, like the result. This blurs texture, which would otherwise break a
// textured object into colours.
std::vector<float> SmoothOverNeighbors(const KdTree& tree,
                                       std::span<const float> values,
                                       int channels,
                                       int num_neighbors,
                                       ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_GEOMETRY_LOCAL_GEOMETRY_H_
