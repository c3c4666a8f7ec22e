// SPDX-License-Identifier: BSD-3-Clause
// A projected Gaussian, which the projection writes and the tiles read.

#ifndef FREEGS_SPLAT_PROJECTION_SPLAT_H_
#define FREEGS_SPLAT_PROJECTION_SPLAT_H_

#include <cstdint>

namespace freegs::splat {

// Blending as in 3DGS: a splat is skipped at a pixel where its alpha is below
// kMinAlpha, alpha is at most kMaxAlpha, and a pixel takes no more splats once
// its transmittance is below kMinTransmittance.
inline constexpr float kMinAlpha = 1.0f / 255.0f;
inline constexpr float kMinLog2Alpha = -7.994353436858858f;  // Its log2.
inline constexpr float kMaxAlpha = 0.99f;
inline constexpr float kMinTransmittance = 1e-4f;

// A projected Gaussian in one cache line.
struct alignas(64) Splat {
  float mean_x, mean_y;  // Pixels.
  // With (dx, dy) = pixel centre - mean,
  //   ln(alpha) = ln(opacity) - (conic_xx (dx + shear dy)^2 + precision_y dy^2)
  //               / 2.
  // This is the inverse covariance as a sum of squares. Its terms have one
  // sign, so nothing cancels, however long and thin the splat is.
  float conic_xx;            // 1 / px^2.
  float shear;               // -cov_xy / cov_yy.
  float precision_y;         // 1 / cov_yy, 1 / px^2.
  float log2_opacity;        // <= 0.
  float extent_x, extent_y;  // Half size of the box where alpha may
                             // reach 1/255, pixels.
  float color[3];
  float depth;
  // The pixels of the image in that box: columns [x_begin, x_end), rows
  // [y_begin, y_end).
  int32_t x_begin, x_end, y_begin, y_end;
};

// The derivative of the loss L with respect to a splat is kept as sums over the
// pixels that the splat touches. With q = dL/dalpha * alpha, (dx, dy) as above
// and e = dx + shear dy they are, in this order: the sums of q, q e, q dy,
// q e^2, q e dy, q dy^2 (the moments), then dL/dcolor (3 numbers), then
// dL/dextra (num_extras numbers). Moments of e, and not of dx, keep what lies
// across a long and thin splat: dx and dy are nearly proportional there.
inline constexpr int kNumMoments = 6;
inline constexpr int kMomentStride = kNumMoments + 3;  // + num_extras.

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_PROJECTION_SPLAT_H_
