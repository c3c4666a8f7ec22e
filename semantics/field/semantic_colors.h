// SPDX-License-Identifier: BSD-3-Clause
// Semantic vectors as colours: like meanings look alike.

#ifndef FREEGS_SEMANTICS_FIELD_SEMANTIC_COLORS_H_
#define FREEGS_SEMANTICS_FIELD_SEMANTIC_COLORS_H_

#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

// N x 3 colours of [0, 1] for N x dim vectors, row-major: red, green and blue
// are the coordinates of the vectors' directions (length left aside) along
// their first three principal axes about the mean, each stretched over [0, 1].
// Vectors of zeros take no part and are black; an axis that is missing or along
// which nothing varies gives one half. One scale for the whole scene, so that
// views agree. kInvalidArgument where the numbers are not rows of dim, or not
// finite.
StatusOr<std::vector<float>> SemanticColors(std::span<const float> features,
                                            int dim,
                                            ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_FIELD_SEMANTIC_COLORS_H_
