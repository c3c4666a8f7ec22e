// SPDX-License-Identifier: BSD-3-Clause
// Products with the matrix W of the blending weights of a view
// (blending_weights.h). A product with W blends values of Gaussians onto
// pixels; a product with its transpose sums values of pixels up for each
// Gaussian. The results are the same bytes for any number of threads.
//
// All matrices are row-major. features and sums are N x channels, with one row
// per Gaussian of the model. pixels is P x channels, with one row per row of W;
// an ImageF of the view's size has this layout. The functions fail with
// kInvalidArgument when sizes disagree, and then change nothing. They do not
// check the entries of W.

#ifndef FREEGS_SPLAT_WEIGHTS_BLENDING_PRODUCTS_H_
#define FREEGS_SPLAT_WEIGHTS_BLENDING_PRODUCTS_H_

#include <cstdint>
#include <span>

#include "core/parallel.h"
#include "core/status.h"
#include "splat/weights/blending_weights.h"

namespace freegs::splat {

// pixels = W features. This blends the features front to back (FreeGS eq. 4
// before the MLP), as RenderView does for FeatureChannels, but for rounding.
Status Multiply(const WeightMatrix& weights,
                std::span<const float> features,
                int channels,
                ThreadPool& pool,
                std::span<float> pixels);

// Computes some rows of W features only: row j of `pixels` becomes that of
// pixel rows[j]. `rows` may be in any order and may repeat pixels.
Status MultiplyAt(const WeightMatrix& weights,
                  std::span<const uint32_t> rows,
                  std::span<const float> features,
                  int channels,
                  ThreadPool& pool,
                  std::span<float> pixels);

// sums += W^T pixels. With pixels = dL/d(W features) this adds dL/dfeatures.
//
// The sums are of type float. They are taken first over the pixels of each tile
// of 16 x 16, then over the tiles in row-major order, so the error is below
// (256 + tiles) 2^-24 times sum_p W(p, i) |pixels(p)|. The threads divide the
// channels among them, 32 at a time, so 32 channels or fewer keep only one
// thread busy.
//
// While it runs it needs memory: 4 bytes per weight, about as much again at
// most for the Gaussians of each tile, and 16 bytes per Gaussian of the model
// for each thread.
Status AddMultiplyTransposed(const WeightMatrix& weights,
                             std::span<const float> pixels,
                             int channels,
                             ThreadPool& pool,
                             std::span<float> sums);

// Like AddMultiplyTransposed, but for some pixels only: row j of `pixels`
// belongs to pixel rows[j]. The sums are taken in the order of `rows`.
Status AddMultiplyTransposedAt(const WeightMatrix& weights,
                               std::span<const uint32_t> rows,
                               std::span<const float> pixels,
                               int channels,
                               ThreadPool& pool,
                               std::span<float> sums);

// sums[i] += sum_p W(p, i), which is the weight of Gaussian i in the whole
// view.
Status AddGaussianWeights(const WeightMatrix& weights, std::span<double> sums);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_WEIGHTS_BLENDING_PRODUCTS_H_
