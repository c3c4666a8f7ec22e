// SPDX-License-Identifier: BSD-3-Clause
// Turns the derivatives of the splats of a view into derivatives of the
// Gaussians, in chunks small enough to stay in the cache.

#ifndef FREEGS_SPLAT_RENDER_PROJECTION_BACKWARD_H_
#define FREEGS_SPLAT_RENDER_PROJECTION_BACKWARD_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/function_ref.h"
#include "core/parallel.h"
#include "splat/projection/projection.h"
#include "splat/render/tile_bins.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

// Receives the gradients of a chunk of Gaussians. Row j of `rows` belongs to
// Gaussian visible[j] (ascending). `rows` has the model's SH degree and may
// have more rows than `visible` has entries; it is valid until the sink
// returns.
using GradientSink = FunctionRef<void(std::span<const uint32_t> visible,
                                      const GaussianGradients& rows)>;

// A view, and the derivatives of the loss L with respect to its splats.
struct SplatDerivatives {
  ProjectionTask view;
  const Projection* projection = nullptr;
  const TileBins* bins = nullptr;

  // For each entry of the bins kMomentStride + num_extras floats: its sums over
  // the pixels of the tile, see kMomentStride in splat.h. The depth channel,
  // when there is one, is extra 0 and the features follow.
  std::span<const float> pair_moments;
  int num_extras = 0;
  bool has_depth = false;

  // Output: dL/d(mean in pixels), 2 floats per place in projection->visible.
  std::span<float> mean2d_gradients;
};

// Keeps its scratch memory between calls. The results are the same bytes for
// any number of threads.
class ProjectionBackward {
 public:
  // Gaussians per chunk. Their gradients, their parameters and the two moments
  // of Adam take 4 x 30 KB at SH degree 3, which fits the second-level cache.
  static constexpr int64_t kChunk = 128;

  // Overwrites the rows of the visible Gaussians in *gradients, which has the
  // model's shapes, and in feature_gradients (N x channels) unless that is
  // empty. Other rows are left alone.
  void ToModel(const SplatDerivatives& from,
               ThreadPool& pool,
               GaussianGradients* gradients,
               std::span<float> feature_gradients);

  // Calls the sink once for every chunk of projection->visible, from several
  // threads at the same time. Each Gaussian is in one chunk only, and nothing
  // reads its parameters after the sink has received its gradient, so the sink
  // may update the Gaussian in place.
  void InChunks(const SplatDerivatives& from,
                ThreadPool& pool,
                GradientSink sink);

 private:
  std::vector<GaussianGradients> rows_;  // Rows of a chunk, by worker.
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_RENDER_PROJECTION_BACKWARD_H_
