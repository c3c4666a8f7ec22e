// SPDX-License-Identifier: BSD-3-Clause
// The two passes of the structural loss over a few image rows, vectorised.

#ifndef FREEGS_SPLAT_OPTIM_LOSS_SIMD_H_
#define FREEGS_SPLAT_OPTIM_LOSS_SIMD_H_

#include <array>
#include <cstddef>

namespace freegs::splat {

inline constexpr int kSsimWindowSize = 11;
inline constexpr int kSsimWindowRadius = 5;
inline constexpr float kSsimC1 = 0.01f * 0.01f;
inline constexpr float kSsimC2 = 0.03f * 0.03f;

using SsimWindow = std::array<float, kSsimWindowSize>;

// Number of rows that one call computes together. Their windows overlap in most
// rows, which are then read only once.
inline constexpr int kSsimBlockRows = 4;
inline constexpr int kSsimInputRows = kSsimWindowSize + kSsimBlockRows - 1;

// The image rows under the windows of a block of rows that begins at row y. The
// first is row y - 5. Rows outside the image point to zeros.
using WindowRows = std::array<const float*, kSsimInputRows>;

// A row is 3 * width interleaved floats. The neighbour of a pixel's channel is
// 3 floats further, so the channels need not be separated. Scratch rows have
// this many zeros before and after them; the kernels rely on these and do not
// change them.
inline constexpr size_t kSsimRowPadding = 3 * kSsimWindowRadius;
constexpr size_t SsimScratchRow(size_t n) { return n + 2 * kSsimRowPadding; }
inline constexpr int kSsimScratchRows = 4 * kSsimBlockRows;

// What the second pass needs of each pixel: the partial derivatives of SSIM
// with respect to the means m = E[x], e = E[x^2] and c = E[xy] under the
// window, where x is the rendered image and y the target.
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

// What both passes are given of a block: num_rows rows of n floats each, at
// most kSsimBlockRows of them. `scratch` has kSsimScratchRows rows of
// SsimScratchRow(n) floats.
struct SsimBlock {
  const SsimWindow& window;
  size_t n = 0;
  int num_rows = 0;
  float* scratch = nullptr;
};

// The first pass over a block. Fills num_rows entries of `derivatives` and
// `sums`.
void SsimForwardRows(const WindowRows& rendered,
                     const WindowRows& target,
                     const SsimBlock& block,
                     const SsimDerivativeRow* derivatives,
                     SsimRowSums* sums);

// How much the two terms of the loss count in the gradient.
struct LossFactors {
  float l1 = 0;
  float ssim = 0;
};

// The second pass: gradient[i] = factors.l1 * sign(x - y)
//   + factors.ssim * d(sum of SSIM)/dx.
// The derivative of a blur is the adjoint of that blur, which is the blur
// itself, for the window is symmetric and the images are zero outside.
// rendered, target and gradient point to the first row of the block; the others
// follow it in memory.
void SsimBackwardRows(const SsimDerivativeRows& derivatives,
                      const float* rendered,
                      const float* target,
                      const SsimBlock& block,
                      LossFactors factors,
                      float* gradient);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_OPTIM_LOSS_SIMD_H_
