// SPDX-License-Identifier: BSD-3-Clause
// The inner loops of blending_products.h, SIMD over channels; compiled for
// several instruction sets by Highway and chosen at run time.

#ifndef FREEGS_SPLAT_BLENDING_PRODUCTS_SIMD_H_
#define FREEGS_SPLAT_BLENDING_PRODUCTS_SIMD_H_

#include <cstddef>

#include "splat/blending_weights.h"

namespace freegs::splat {

// Writes rows [first, last) of W features, one after another, to `pixels`.
// features: N x channels.
void MultiplyRows(const WeightMatrix& weights,
                  size_t first,
                  size_t last,
                  const float* features,
                  size_t channels,
                  float* pixels);

// Adds what rows [first, last) give to W^T pixels, channels [channel_begin,
// channel_end) only, to sums (N x channels). Row `first` of the pixels is the
// first at `pixels`.
void AddTransposedRows(const WeightMatrix& weights,
                       size_t first,
                       size_t last,
                       const float* pixels,
                       size_t channels,
                       size_t channel_begin,
                       size_t channel_end,
                       float* sums);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_BLENDING_PRODUCTS_SIMD_H_
