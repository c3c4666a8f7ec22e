// SPDX-License-Identifier: BSD-3-Clause
// What its nearest neighbours tell of a point: the normal of the surface.

#ifndef FREEGS_SEMANTICS_GEOMETRY_LOCAL_GEOMETRY_H_
#define FREEGS_SEMANTICS_GEOMETRY_LOCAL_GEOMETRY_H_

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

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_GEOMETRY_LOCAL_GEOMETRY_H_
