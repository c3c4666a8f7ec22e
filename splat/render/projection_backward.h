// SPDX-License-Identifier: BSD-3-Clause
// From derivatives of the splats of a view to those of the Gaussians, in chunks
// that stay in the cache.

#ifndef FREEGS_SPLAT_RENDER_PROJECTION_BACKWARD_H_
#define FREEGS_SPLAT_RENDER_PROJECTION_BACKWARD_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/function_ref.h"
#include "core/parallel.h"
#include "splat/scene/gaussian_model.h"
#include "splat/projection/projection.h"
#include "splat/render/tile_bins.h"

namespace freegs::splat {

// Takes the gradients of a chunk: row j of `rows`, a container of the model's
// SH degree with that many rows or more, belongs to Gaussian visible[j]
// (ascending). The rows live until it returns.
using GradientSink = FunctionRef<void(std::span<const uint32_t> visible,
                                      const GaussianGradients& rows)>;

// A view and what its pixels want of its splats.
struct SplatDerivatives {
  ProjectionTask view;
  const Projection* projection = nullptr;
  const TileBins* bins = nullptr;

  // Per entry of the bins its sums over pixels (see tile_kernels.h):
  // kMomentStride + num_extras floats each. The depth channel, when there is
  // one, is extra 0 and the features follow.
  std::span<const float> pair_moments;
  int num_extras = 0;
  bool has_depth = false;

  // Out: dL/d(2D mean) in pixels, 2 floats per splat.
  std::span<float> mean2d_gradients;
};

// Keeps its scratch memory between calls. The same bytes for any number of
// threads.
class ProjectionBackward {
 public:
  // Gaussians per chunk. Their gradients, parameters and two moments take
  // 4 x 30 KB at SH degree 3: a part of the second-level cache.
  static constexpr int64_t kChunk = 128;

  // Overwrites the visible Gaussians' rows of *gradients (the model's shapes)
  // and, when not empty, of feature_gradients (N x channels); other rows are
  // left alone.
  void ToModel(const SplatDerivatives& from,
               ThreadPool& pool,
               GaussianGradients* gradients,
               std::span<float> feature_gradients);

  // Calls the sink once for every chunk of projection->visible, concurrently.
  // Each Gaussian is in one chunk only, and nothing reads its parameters once
  // the sink has its gradient: the sink may update it in place.
  void InChunks(const SplatDerivatives& from,
                ThreadPool& pool,
                GradientSink sink);

 private:
  void SumPairs(const SplatDerivatives& from,
                ThreadPool& pool,
                std::span<float> feature_gradients);
  // Entries [begin, end) of projection->visible, without a place for gradients.
  ProjectionBackwardTask MakeTask(const SplatDerivatives& from,
                                  int64_t begin,
                                  int64_t end) const;

  std::vector<SplatSums> sums_;          // By rank.
  std::vector<GaussianGradients> rows_;  // Of a chunk, by worker.
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_RENDER_PROJECTION_BACKWARD_H_
