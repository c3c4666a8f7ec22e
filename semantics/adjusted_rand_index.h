// SPDX-License-Identifier: BSD-3-Clause
// How far two clusterings agree, whatever their clusters are called.

#ifndef FREEGS_SEMANTICS_ADJUSTED_RAND_INDEX_H_
#define FREEGS_SEMANTICS_ADJUSTED_RAND_INDEX_H_

#include <cstdint>
#include <span>

namespace freegs::semantics {

// The adjusted Rand index (Hubert and Arabie 1985): 1 for the same partition,
// about 0 for independent ones, negative below chance. Of two labels per point,
// as many of each; negative labels are noise, which counts as one more cluster.
// 1 when there is nothing to tell apart: fewer than two points, or both
// clusterings all in one or all apart.
double AdjustedRandIndex(std::span<const int32_t> a,
                         std::span<const int32_t> b);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_ADJUSTED_RAND_INDEX_H_
