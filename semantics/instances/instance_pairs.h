// SPDX-License-Identifier: BSD-3-Clause
// Instances that may be parts of one thing.

#ifndef FREEGS_SEMANTICS_INSTANCES_INSTANCE_PAIRS_H_
#define FREEGS_SEMANTICS_INSTANCES_INSTANCE_PAIRS_H_

#include <cstdint>
#include <span>
#include <vector>

#include "semantics/instances/hierarchy.h"
#include "semantics/patches/region_graph.h"

namespace freegs::semantics {

// Two instances, by their labels.
struct InstancePair {
  int32_t a = 0;
  int32_t b = 0;

  friend bool operator==(const InstancePair&, const InstancePair&) = default;
};

// A pair that is one thing, and how sure that is, from 0 to 1.
struct WholePair {
  InstancePair pair;
  double confidence = 0;
};

// The pairs of instances of a hierarchy, at its own granularity, that touch one
// another. None of them is background: a plane (is_plane, for each label), or a
// quarter of all pixels. The smaller has at least 0.3 times the pixels of the
// larger, because a few more pixels change little of what is seen, and chance
// decides whether that looks better. graph: its regions are the hierarchy's
// leaves. By a, then b; a < b.
std::vector<InstancePair> PairsThatMeet(const Hierarchy& hierarchy,
                                        const RegionGraph& graph,
                                        std::span<const uint8_t> is_plane);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_INSTANCE_PAIRS_H_
