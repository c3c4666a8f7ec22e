// SPDX-License-Identifier: BSD-3-Clause
// Makes one region of two that a tree does not have together.

#ifndef FREEGS_SEMANTICS_PATCHES_REGION_JOINING_H_
#define FREEGS_SEMANTICS_PATCHES_REGION_JOINING_H_

#include <cstdint>
#include <vector>

#include "semantics/patches/region_merging.h"

namespace freegs::semantics {

struct JoinedTree {
  RegionTree tree;

  // For each region of the old tree, its number in the new one. A region that
  // held one of the two gains or loses the leaves of `b`. -1 for the region
  // that consisted of `b` and another one without `a`: the other one remains of
  // it.
  std::vector<int32_t> place;

  int32_t joined = -1;  // Region of the new tree: all leaves of the two.
};

// Takes region b out of what it was joined to, and joins it to region a first
// of all. Heights that would descend are raised. Neither may be in the other.
// If the two are joined already, the tree stays as it is.
JoinedTree JoinRegions(const RegionTree& tree, int32_t a, int32_t b);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_REGION_JOINING_H_
