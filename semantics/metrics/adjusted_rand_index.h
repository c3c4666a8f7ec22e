// SPDX-License-Identifier: BSD-3-Clause
// Agreement of two partitions of the same things.

#ifndef FREEGS_SEMANTICS_METRICS_ADJUSTED_RAND_INDEX_H_
#define FREEGS_SEMANTICS_METRICS_ADJUSTED_RAND_INDEX_H_

#include <cstdint>
#include <span>

#include "core/status.h"

namespace freegs::semantics {

// The Rand index corrected for chance (Hubert and Arabie, "Comparing
// Partitions", 1985, equation 5): 1 for equal partitions, near 0 for unrelated
// ones, negative for less agreement than chance gives. Labels only say who
// belongs together; each value, -1 (noise) too, is a class. 1 where both put
// all in one class or each in its own, or where there are fewer than two
// things. kInvalidArgument when the sizes differ. Time N log N, memory N.
StatusOr<double> AdjustedRandIndex(std::span<const int32_t> a,
                                   std::span<const int32_t> b);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_METRICS_ADJUSTED_RAND_INDEX_H_
