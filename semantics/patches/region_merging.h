// SPDX-License-Identifier: BSD-3-Clause
// Joins regions pair by pair, what is surest to be one thing first.

#ifndef FREEGS_SEMANTICS_PATCHES_REGION_MERGING_H_
#define FREEGS_SEMANTICS_PATCHES_REGION_MERGING_H_

#include <cstdint>
#include <functional>
#include <span>
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

    friend bool operator==(const Merge&, const Merge&) = default;
  };
  int num_leaves = 0;
  std::vector<Merge> merges;

  // Applies the merges of at most this height. Returns the region of each leaf.
  std::vector<int32_t> Cut(double height) const;

  // Chooses one region for each leaf so that the sum of `worth` over the chosen
  // regions is largest. `worth` has a number >= 0 for each region. Large and
  // small things can be chosen together, because no single height has to fit
  // all.
  //
  // A crumb, a region of less than min_size in all, the sum of its leaves'
  // sizes, is no thing and makes none: it belongs to what it was joined to, or
  // to the largest part of that. One that was joined to nothing stays a crumb.
  std::vector<int32_t> MostWorth(std::span<const double> worth,
                                 std::span<const double> leaf_sizes,
                                 double min_size) const;

  // Sums of what the leaves have, for all regions.
  std::vector<double> Sums(std::span<const double> of_leaves) const;
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

// Merges in the same way. of_contacts: what EvidenceOfContacts returns for
// `graph`, for callers that have it already.
RegionTree MergeRegions(RegionGraph graph,
                        std::span<const Evidence> of_contacts,
                        const DifferenceFn& difference,
                        const AllowFn& allow = nullptr);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_REGION_MERGING_H_
