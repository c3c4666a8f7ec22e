// SPDX-License-Identifier: BSD-3-Clause
// The two passes of the structural loss over a few image rows, vectorised.

#ifndef FREEGS_SPLAT_OPTIM_LOSS_SIMD_H_
#define FREEGS_SPLAT_OPTIM_LOSS_SIMD_H_

#include <array>
#include <cstddef>

namespace freegs::splat {

constexpr int kSsimWindowSize = 11;
constexpr int kSsimWindowRadius = 5;
constexpr float kSsimC1 = 0.01f * 0.01f;
constexpr float kSsimC2 = 0.03f * 0.03f;

using SsimWindow = std::array<float, kSsimWindowSize>;

// Rows that a call computes together: they share most of the rows under their
// windows, which are then read once.
constexpr int kSsimBlockRows = 4;
constexpr int kSsimInputRows = kSsimWindowSize + kSsimBlockRows - 1;

// The image rows under the windows of a block that begins at row y: from y - 5
// on. Rows outside of the image point to zeros.
using WindowRows = std::array<const float*, kSsimInputRows>;

// A row is 3 * width interleaved floats, in which a pixel's neighbour is 3
// floats on: no need to separate the channels. Scratch rows have this many
// zeros before and after, which the kernels rely on and keep.
constexpr size_t kSsimRowPadding = 3 * kSsimWindowRadius;
constexpr size_t SsimScratchRow(size_t n) { return n + 2 * kSsimRowPadding; }
constexpr int kSsimScratchRows = 4 * kSsimBlockRows;

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

// First pass over the first num_rows rows of a block, n floats each.
// `scratch` holds kSsimScratchRows rows of SsimScratchRow(n) floats;
// derivatives and sums have num_rows entries.
void SsimForwardRows(const WindowRows& rendered,
                     const WindowRows& target,
                     const SsimWindow& window,
                     size_t n,
                     int num_rows,
                     float* scratch,
                     const SsimDerivativeRow* derivatives,
                     SsimRowSums* sums);

// Second pass: gradient[i] = l1_factor * sign(x - y)
//   + ssim_factor * d (sum of SSIM) / d x. The window is symmetric, so the
// adjoint of the blur with zeros outside is that blur. rendered, target and
// gradient are the block's first rows, one after the other in memory.
void SsimBackwardRows(const SsimDerivativeRows& derivatives,
                      const float* rendered,
                      const float* target,
                      const SsimWindow& window,
                      float l1_factor,
                      float ssim_factor,
                      size_t n,
                      int num_rows,
                      float* scratch,
                      float* gradient);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_OPTIM_LOSS_SIMD_H_
