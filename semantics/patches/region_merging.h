// SPDX-License-Identifier: BSD-3-Clause
// Joins regions pair by pair, what is surest to be one thing first.

#ifndef FREEGS_SEMANTICS_PATCHES_REGION_MERGING_H_
#define FREEGS_SEMANTICS_PATCHES_REGION_MERGING_H_

#include <cstdint>
#include <functional>
#include <vector>

#include "semantics/patches/evidence.h"
#include "semantics/patches/region_graph.h"

namespace freegs::semantics {

// Regions 0 .. num_leaves - 1 are those of the graph; merge k makes region
// num_leaves + k of two earlier ones. Heights never descend.
struct RegionTree {
  struct Merge {
    int32_t a = 0;
    int32_t b = 0;
    double height = 0;
  };
  int num_leaves = 0;
  std::vector<Merge> merges;

  // Applies the merges of at most this height. Returns the region of each leaf.
  std::vector<int32_t> Cut(double height) const;
};

// How much speaks against two regions being one thing, from -infinity to
// infinity; at 0 it is as likely as not.
using DifferenceFn = std::function<double(const Evidence&)>;

// If given, is asked before two regions are joined; those it refuses stay apart
// until one of them has grown. For learning.
using AllowFn =
    std::function<bool(int32_t a, int32_t b, const Evidence& evidence)>;

// Greedy: of all pairs that touch, those of the smallest difference are joined
// first; the evidence is measured anew for what grew (Nunez-Iglesias et al.
// 2013).
RegionTree MergeRegions(RegionGraph graph,
                        const DifferenceFn& difference,
                        const AllowFn& allow = nullptr);

// Joins regions of fewer pixels than this to the neighbour from which they
// differ least, whatever speaks against it, the smallest first.
// region_of_patch: any numbers; returns numbers 0 .. n - 1 in their place.
std::vector<int32_t> AbsorbSmallRegions(
    const RegionGraph& graph,
    const std::vector<int32_t>& region_of_patch,
    const DifferenceFn& difference,
    double min_pixels);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_REGION_MERGING_H_
