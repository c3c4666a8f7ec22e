// SPDX-License-Identifier: BSD-3-Clause
// The 3D smoothing loss (FreeGS eq. 3): the features of neighbouring Gaussians
// point in the same direction.

#ifndef FREEGS_SEMANTICS_LOSSES_SMOOTHING_LOSS_H_
#define FREEGS_SEMANTICS_LOSSES_SMOOTHING_LOSS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

struct SmoothingOptions {
  int num_neighbours = 5;   // K, nearest neighbours of each sample.
  double fraction = 0.001;  // Share of all Gaussians sampled in a step (T).
  int min_samples = 64;     // But at least so many, if there are so many.

  Status Check() const;
};

// The nearest neighbours of every Gaussian. They stay the same while the
// geometry is frozen. Among equal distances the smaller index comes first. A
// Gaussian that has none stands in their places itself.
struct NeighborTable {
  int num_neighbours = 0;         // Per Gaussian.
  std::vector<uint32_t> indices;  // N x num_neighbours, nearest first.

  size_t size() const {
    return num_neighbours > 0 ? indices.size() / num_neighbours : 0;
  }
};

// positions: N x 3. If N <= K, each Gaussian has the N - 1 others as
// neighbours, so that the table of a single Gaussian is empty. Gaussians beyond
// KdTree::kMaxCoordinate have no neighbours and are nobody's; N counts the
// others. kInvalidArgument for K < 1 and for positions that are not of three
// numbers each.
StatusOr<NeighborTable> BuildNeighborTable(std::span<const float> positions,
                                           int num_neighbours,
                                           ThreadPool& pool);

// Returns T different Gaussians of `count`, ascending, for one step of
// training. They depend on seed and step only. One is drawn from each of T
// equal runs of indices, so that in a model in spatial order the samples are
// spread over the scene.
std::vector<uint32_t> SampleForSmoothing(const SmoothingOptions& options,
                                         size_t count,
                                         uint64_t seed,
                                         uint64_t step);

// Returns L, the mean of 1 - cos(f_i, f_j) over the samples i and their
// neighbours j, and adds weight dL/df of both ends to `gradients`. Pairs with a
// vector of no length (below 1e-12) do not count, nor do samples without
// neighbours; L is 0 if no pair counts.
//   features   N x D, row-major
//   gradients  N x D; the rows of samples and of their neighbours change
// kInvalidArgument for sizes that disagree, samples out of range and features
// that are not finite; then `gradients` are unchanged.
StatusOr<double> SmoothingLoss(std::span<const float> features,
                               int dim,
                               const NeighborTable& table,
                               std::span<const uint32_t> samples,
                               double weight,
                               ThreadPool& pool,
                               std::span<float> gradients);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_SMOOTHING_LOSS_H_
