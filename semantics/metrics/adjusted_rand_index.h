// SPDX-License-Identifier: BSD-3-Clause
// How well two partitions of the same things agree.

#ifndef FREEGS_SEMANTICS_METRICS_ADJUSTED_RAND_INDEX_H_
#define FREEGS_SEMANTICS_METRICS_ADJUSTED_RAND_INDEX_H_

#include <cstdint>
#include <span>

#include "core/status.h"

namespace freegs::semantics {

// Returns the Rand index corrected for chance (Hubert and Arabie, "Comparing
// Partitions", 1985, equation 5). It is 1 for equal partitions, near 0 for
// unrelated ones, and negative for less agreement than chance gives. Each value
// is a class, also -1 (noise). The index is 1 if both partitions put everything
// in one class, if both put each thing in a class of its own, or if there are
// fewer than two things. kInvalidArgument if the sizes differ. Time N log N,
// memory N.
StatusOr<double> AdjustedRandIndex(std::span<const int32_t> a,
                                   std::span<const int32_t> b);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_METRICS_ADJUSTED_RAND_INDEX_H_
