// SPDX-License-Identifier: BSD-3-Clause
// A projected Gaussian, as the kernels of projection and of the tiles share it.

#ifndef FREEGS_SPLAT_PROJECTION_SPLAT_H_
#define FREEGS_SPLAT_PROJECTION_SPLAT_H_

#include <cstdint>

namespace freegs::splat {

constexpr float kMinAlpha = 1.0f / 255.0f;
constexpr float kMaxAlpha = 0.99f;
constexpr float kMinTransmittance = 1e-4f;

// A projected Gaussian as the kernels read it: one cache line.
struct alignas(64) Splat {
  float mean_x, mean_y;                // Pixels.
  float conic_xx, conic_xy, conic_yy;  // Inverse covariance, 1 / px^2.
  float log2_opacity;                  // <= 0.
  float extent_x, extent_y;            // Half size of the box where alpha may
                                       // reach 1/255, pixels.
  float color[3];
  float depth;
  // That box as pixels of the image: columns [x_begin, x_end) and rows.
  int32_t x_begin, x_end, y_begin, y_end;
};

// Sums over the pixels of a tile that one splat contributes, in this order;
// q = dL/dalpha * alpha and (dx, dy) = pixel centre - mean:
// sum q, q dx, q dy, q dx^2, q dx dy, q dy^2, then dL/dcolor (3), then
// dL/dextra (num_extras).
constexpr int kNumMoments = 6;
constexpr int kMomentStride = kNumMoments + 3;  // + num_extras.

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_PROJECTION_SPLAT_H_
