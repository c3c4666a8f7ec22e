// SPDX-License-Identifier: BSD-3-Clause
// Joins clusters that are fragments of one thing, and gives labels to noise.

#ifndef FREEGS_SEMANTICS_INSTANCES_CLUSTER_MERGING_H_
#define FREEGS_SEMANTICS_INSTANCES_CLUSTER_MERGING_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"

namespace freegs::semantics {

// Joins two clusters if both of these are true:
// - at least 0.5 % of the points of the smaller cluster, and at least one, have
// a
//   point of the other cluster within `distance`;
// - the mean colours of the clusters differ by less than `color_difference`.
// Joins are transitive; mean colours are those before any join.
//
// positions, colors: N x 3. labels: N, -1 for none; changed in place. A joined
// cluster has the smallest label of its parts.
void MergeClusters(std::span<const float> positions,
                   std::span<const float> colors,
                   double distance,
                   double color_difference,
                   ThreadPool& pool,
                   std::vector<int32_t>* labels);

// A point with label -1 takes the label of the nearest point that has one, if
// that point is within `distance`.
void LabelNoise(std::span<const float> positions,
                double distance,
                ThreadPool& pool,
                std::vector<int32_t>* labels);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_CLUSTER_MERGING_H_
