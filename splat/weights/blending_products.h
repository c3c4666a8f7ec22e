// SPDX-License-Identifier: BSD-3-Clause
// Products with the blending weights W of a view (blending_weights.h): what
// Gaussians carry onto pixels, and what pixels say back to Gaussians. SIMD over
// channels. The results are the same bytes for any number of threads.
//
// All matrices are row-major: features and sums N x channels, one row per
// Gaussian of the model; pixels P x channels, one row per row of W (an ImageF
// of the view's size is one). Functions return kInvalidArgument when sizes
// disagree, and then change nothing; the entries of W are trusted.

#ifndef FREEGS_SPLAT_WEIGHTS_BLENDING_PRODUCTS_H_
#define FREEGS_SPLAT_WEIGHTS_BLENDING_PRODUCTS_H_

#include <cstdint>
#include <span>

#include "core/parallel.h"
#include "core/status.h"
#include "splat/weights/blending_weights.h"

namespace freegs::splat {

// pixels = W features: features blended front to back (FreeGS eq. 4 before the
// MLP), what RenderView gives for FeatureChannels but for rounding.
Status Multiply(const WeightMatrix& weights,
                std::span<const float> features,
                int channels,
                ThreadPool& pool,
                std::span<float> pixels);

// The same for some pixels only: row j of `pixels` is that of pixel rows[j],
// in any order, repeated or not.
Status MultiplyAt(const WeightMatrix& weights,
                  std::span<const uint32_t> rows,
                  std::span<const float> features,
                  int channels,
                  ThreadPool& pool,
                  std::span<float> pixels);

// sums += W^T pixels. With pixels = dL/d(W features) this adds dL/dfeatures.
//
// Sums are in float, over the pixels of each tile of 16 x 16 and then over the
// tiles, in rows: relative to sum_p W(p, i) |pixels(p)| the error is below
// (256 + tiles) 2^-24. Threads share out the channels, 32 at a time: fewer than
// that keep one thread busy. Takes 4 bytes per weight while it runs.
Status AddMultiplyTransposed(const WeightMatrix& weights,
                             std::span<const float> pixels,
                             int channels,
                             ThreadPool& pool,
                             std::span<float> sums);

// The same for some pixels only, summed in the order of `rows`: row j of
// `pixels` belongs to pixel rows[j].
Status AddMultiplyTransposedAt(const WeightMatrix& weights,
                               std::span<const uint32_t> rows,
                               std::span<const float> pixels,
                               int channels,
                               ThreadPool& pool,
                               std::span<float> sums);

// sums[i] += sum_p W(p, i), the weight a Gaussian has in the whole view; one
// number per Gaussian.
Status AddGaussianWeights(const WeightMatrix& weights, std::span<double> sums);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_WEIGHTS_BLENDING_PRODUCTS_H_
