// SPDX-License-Identifier: BSD-3-Clause
// The inner loops of blending_products.h, SIMD over channels; compiled for
// several instruction sets by Highway and chosen at run time.

#ifndef FREEGS_SPLAT_WEIGHTS_BLENDING_PRODUCTS_SIMD_H_
#define FREEGS_SPLAT_WEIGHTS_BLENDING_PRODUCTS_SIMD_H_

#include <cstddef>

#include "splat/weights/blending_weights.h"

namespace freegs::splat {

// Writes rows [first, last) of W features, one after another, to `pixels`.
// features: N x channels.
void MultiplyRows(const WeightMatrix& weights,
                  size_t first,
                  size_t last,
                  const float* features,
                  size_t channels,
                  float* pixels);

// Adds to row i of `sums` what the rows [first, last) give to row i of W^T
// pixels. `pixels` points to the first channel of row `first`, `sums` to that
// of row 0; rows are `channels` of them, a stride apart.
void AddTransposedRows(const WeightMatrix& weights,
                       size_t first,
                       size_t last,
                       const float* pixels,
                       size_t pixel_stride,
                       size_t channels,
                       float* sums,
                       size_t sum_stride);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_WEIGHTS_BLENDING_PRODUCTS_SIMD_H_
