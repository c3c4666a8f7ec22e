// SPDX-License-Identifier: BSD-3-Clause
// The 3D smoothing loss (FreeGS eq. 3): features of neighbours point the same
// way.

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
  int neighbors = 5;        // K, nearest neighbours of each sample.
  double fraction = 0.001;  // T, samples per step, of all Gaussians,
  int min_samples = 64;     // but no fewer than these, if there are so many.

  Status Check() const;
};

// The nearest neighbours of every Gaussian, which stay what they are while the
// geometry is frozen. Among equal distances those of smaller index.
struct NeighborTable {
  int neighbors = 0;              // Per Gaussian.
  std::vector<uint32_t> indices;  // N x neighbors, nearest first.

  size_t size() const { return neighbors > 0 ? indices.size() / neighbors : 0; }
};

// positions: N x 3. With N <= K each has the N - 1 others as neighbours, and a
// single Gaussian has none: the table is empty. kInvalidArgument for K < 1 and
// for positions that are no points (see KdTree::Build).
StatusOr<NeighborTable> BuildNeighborTable(std::span<const float> positions,
                                           int neighbors,
                                           ThreadPool& pool);

// T different Gaussians of `count` for one step of training, ascending: a
// function of seed and step alone. One from each of T equal runs of indices, so
// that they are spread over a model in spatial order.
std::vector<uint32_t> SampleForSmoothing(const SmoothingOptions& options,
                                         size_t count,
                                         uint64_t seed,
                                         uint64_t step);

// Returns L, the mean of 1 - cos(f_i, f_j) over the samples i and their
// neighbours j, and adds weight dL/df of both ends to `gradients`. A vector of
// length 0 (below 1e-12) has no direction: pairs with one do not count. 0 when
// no pair does.
//   features   N x D, row-major
//   gradients  N x D; rows of samples and their neighbours change
// kInvalidArgument for sizes that disagree, samples out of range and features
// that are not finite; then `gradients` are as before.
StatusOr<double> SmoothingLoss(std::span<const float> features,
                               int dim,
                               const NeighborTable& table,
                               std::span<const uint32_t> samples,
                               double weight,
                               ThreadPool& pool,
                               std::span<float> gradients);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_SMOOTHING_LOSS_H_
