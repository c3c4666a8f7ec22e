// SPDX-License-Identifier: BSD-3-Clause
// The two passes of the structural loss over one image row, vectorised.

#ifndef FREEGS_SPLAT_LOSS_SIMD_H_
#define FREEGS_SPLAT_LOSS_SIMD_H_

#include <array>
#include <cstddef>

namespace freegs::splat {

constexpr int kSsimWindowSize = 11;
constexpr int kSsimWindowRadius = 5;
constexpr float kSsimC1 = 0.01f * 0.01f;
constexpr float kSsimC2 = 0.03f * 0.03f;

using SsimWindow = std::array<float, kSsimWindowSize>;

// The image rows under the window, from y - 5 to y + 5. Rows outside of the
// image point to zeros.
using WindowRows = std::array<const float*, kSsimWindowSize>;

// A row is 3 * width interleaved floats, in which a pixel's neighbour is 3
// floats on: no need to separate the channels. Scratch rows have this many
// zeros before and after, which the kernels rely on and keep.
constexpr size_t kSsimRowPadding = 3 * kSsimWindowRadius;
constexpr size_t SsimScratchRow(size_t n) { return n + 2 * kSsimRowPadding; }
constexpr int kSsimScratchRows = 4;

// What the gradient needs of a pixel. With m = E[x], e = E[x^2], c = E[xy]
// under the window (x rendered, y target) these are the derivatives of SSIM
// with respect to m, e and c, the others held.
struct SsimDerivativeRow {
  float* mean;
  float* square;
  float* product;
};
struct SsimDerivativeRows {
  WindowRows mean;
  WindowRows square;
  WindowRows product;
};

struct SsimRowSums {
  double absolute_difference = 0;
  double ssim = 0;
};

// First pass over the middle row of `rendered` and `target`, n floats.
// `scratch` holds kSsimScratchRows rows of SsimScratchRow(n) floats.
SsimRowSums SsimForwardRow(const WindowRows& rendered,
                           const WindowRows& target,
                           const SsimWindow& window,
                           size_t n,
                           float* scratch,
                           const SsimDerivativeRow& derivatives);

// Second pass: gradient[i] = l1_factor * sign(x - y)
//   + ssim_factor * d (sum of SSIM) / d x. The window is symmetric, so the
// adjoint of the blur with zeros outside is that blur.
void SsimBackwardRow(const SsimDerivativeRows& derivatives,
                     const float* rendered,
                     const float* target,
                     const SsimWindow& window,
                     float l1_factor,
                     float ssim_factor,
                     size_t n,
                     float* scratch,
                     float* gradient);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_LOSS_SIMD_H_
