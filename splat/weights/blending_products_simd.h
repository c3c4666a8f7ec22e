// SPDX-License-Identifier: BSD-3-Clause
// The inner loops of blending_products.h, with one channel per SIMD lane.
// Highway compiles them for several instruction sets and chooses one at run
// time.

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

// Adds the part of W^T pixels that comes from pixels [first, last) to `sums`.
// `pixels` points to the row of pixel `first`, `sums` to the row of Gaussian 0.
// Only the first `channels` numbers of each row take part; the strides are the
// distances from one row to the next, in floats.
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
