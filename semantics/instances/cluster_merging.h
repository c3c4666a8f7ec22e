// SPDX-License-Identifier: BSD-3-Clause
// Joins fragments of one thing.

#ifndef FREEGS_SEMANTICS_INSTANCES_CLUSTER_MERGING_H_
#define FREEGS_SEMANTICS_INSTANCES_CLUSTER_MERGING_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"

namespace freegs::semantics {

// positions, colors: N x 3; labels: N, -1 for none, changed in place (labels of
// joined clusters become the smallest of them). Two clusters are joined when at
// least 0.5 % of the smaller one's points (and at least one) have a point of
// the other within `distance`, and the mean colours differ by less than
// `color_difference`. Joins are transitive; means are those before any join.
void MergeClusters(std::span<const float> positions,
                   std::span<const float> colors,
                   double distance,
                   double color_difference,
                   ThreadPool& pool,
                   std::vector<int32_t>* labels);

// Points with label -1 take the label of the nearest point that has one, if it
// is within `distance`.
void LabelNoise(std::span<const float> positions,
                double distance,
                ThreadPool& pool,
                std::vector<int32_t>* labels);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_CLUSTER_MERGING_H_
