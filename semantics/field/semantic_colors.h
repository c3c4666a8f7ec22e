// SPDX-License-Identifier: BSD-3-Clause
// Shows semantic vectors as colours: what has a similar meaning has a similar
// colour.

#ifndef FREEGS_SEMANTICS_FIELD_SEMANTIC_COLORS_H_
#define FREEGS_SEMANTICS_FIELD_SEMANTIC_COLORS_H_

#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

// Returns N x 3 colours in [0, 1] for N x dim vectors, row-major. Red, green
// and blue are the coordinates of the directions of the vectors along their
// first three principal axes about the mean. Each coordinate is stretched over
// [0, 1]; 2 % of the vectors at each end are cut off. The scale is that of the
// whole scene, so that all views agree.
//
// Zero vectors do not take part and are black. A channel is one half if its
// axis is missing or nothing varies along it. kInvalidArgument if the numbers
// are not rows of dim, or not finite.
StatusOr<std::vector<float>> SemanticColors(std::span<const float> features,
                                            int dim,
                                            ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_FIELD_SEMANTIC_COLORS_H_
