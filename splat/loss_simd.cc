// SPDX-License-Identifier: BSD-3-Clause

#include "splat/loss_simd.h"

#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/loss_simd.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace freegs::splat::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Wide = hn::ScalableTag<float>;
using One = hn::CappedTag<float, 1>;  // For the rest of a row.

// Blurs along the row around float i of a scratch row.
template <class D>
HWY_INLINE hn::Vec<D> BlurAlong(D d,
                                const float* row,
                                const SsimWindow& window,
                                size_t i) {
  const float* const centre = row + kSsimRowPadding + i;
  auto sum =
      hn::Mul(hn::Set(d, window[kSsimWindowRadius]), hn::LoadU(d, centre));
  for (int k = 1; k <= kSsimWindowRadius; ++k) {
    const auto pair =
        hn::Add(hn::LoadU(d, centre - 3 * k), hn::LoadU(d, centre + 3 * k));
    sum = hn::MulAdd(hn::Set(d, window[kSsimWindowRadius + k]), pair, sum);
  }
  return sum;
}

// Blurs across rows: E[x], E[y], E[x^2 + y^2], E[x y] of column i into the four
// scratch rows. SSIM needs the squares' sum only.
template <class D>
HWY_INLINE void BlurAcross(D d,
                           const WindowRows& rendered,
                           const WindowRows& target,
                           const SsimWindow& window,
                           size_t i,
                           float* scratch,
                           size_t scratch_row) {
  auto x_sum = hn::Zero(d);
  auto y_sum = hn::Zero(d);
  auto square_sum = hn::Zero(d);
  auto product_sum = hn::Zero(d);
  for (int k = 0; k < kSsimWindowSize; ++k) {
    const auto w = hn::Set(d, window[k]);
    const auto x = hn::LoadU(d, rendered[k] + i);
    const auto y = hn::LoadU(d, target[k] + i);
    const auto wx = hn::Mul(w, x);
    const auto wy = hn::Mul(w, y);
    x_sum = hn::Add(x_sum, wx);
    y_sum = hn::Add(y_sum, wy);
    square_sum = hn::MulAdd(wx, x, hn::MulAdd(wy, y, square_sum));
    product_sum = hn::MulAdd(wx, y, product_sum);
  }
  float* const at = scratch + kSsimRowPadding + i;
  hn::StoreU(x_sum, d, at);
  hn::StoreU(y_sum, d, at + scratch_row);
  hn::StoreU(square_sum, d, at + 2 * scratch_row);
  hn::StoreU(product_sum, d, at + 3 * scratch_row);
}

// SSIM = (2 m n + C1)(2 (c - m n) + C2) /
//        ((m^2 + n^2 + C1)(E[x^2 + y^2] - m^2 - n^2 + C2)), n = E[y].
template <class D>
HWY_INLINE hn::Vec<D> SsimAt(D d,
                             const float* scratch,
                             size_t scratch_row,
                             const SsimWindow& window,
                             size_t i,
                             const SsimDerivativeRow& derivatives) {
  const auto m = BlurAlong(d, scratch, window, i);
  const auto n = BlurAlong(d, scratch + scratch_row, window, i);
  const auto squares = BlurAlong(d, scratch + 2 * scratch_row, window, i);
  const auto product = BlurAlong(d, scratch + 3 * scratch_row, window, i);
  const auto c1 = hn::Set(d, kSsimC1);
  const auto c2 = hn::Set(d, kSsimC2);
  const auto two = hn::Set(d, 2.0f);
  const auto mn = hn::Mul(m, n);
  const auto mean_squares = hn::MulAdd(m, m, hn::Mul(n, n));
  const auto a1 = hn::MulAdd(two, mn, c1);
  const auto a2 = hn::MulAdd(two, hn::Sub(product, mn), c2);
  const auto b1 = hn::Add(mean_squares, c1);
  const auto b2 = hn::Add(hn::Sub(squares, mean_squares), c2);
  const auto inverse = hn::Div(hn::Set(d, 1.0f), hn::Mul(b1, b2));
  const auto ssim = hn::Mul(hn::Mul(a1, a2), inverse);

  const auto by_product = hn::Mul(hn::Mul(two, a1), inverse);
  // -SSIM / B2, with 1 / B2 = B1 / (B1 B2).
  const auto by_square = hn::Neg(hn::Mul(ssim, hn::Mul(b1, inverse)));
  // 2 n (A2 - A1) / (B1 B2) + 2 m SSIM (1 / B2 - 1 / B1).
  const auto through_n = hn::Mul(hn::Mul(n, hn::Sub(a2, a1)), inverse);
  const auto through_m =
      hn::Mul(hn::Mul(m, ssim), hn::Mul(hn::Sub(b1, b2), inverse));
  hn::StoreU(
      hn::Mul(two, hn::Add(through_n, through_m)), d, derivatives.mean + i);
  hn::StoreU(by_square, d, derivatives.square + i);
  hn::StoreU(by_product, d, derivatives.product + i);
  return ssim;
}

SsimRowSums ForwardRow(const WindowRows& rendered,
                       const WindowRows& target,
                       const SsimWindow& window,
                       size_t n,
                       float* scratch,
                       const SsimDerivativeRow& derivatives) {
  const Wide wide;
  const One one;
  const size_t lanes = hn::Lanes(wide);
  const size_t whole = n - n % lanes;
  const size_t stride = SsimScratchRow(n);
  const float* const x = rendered[kSsimWindowRadius];
  const float* const y = target[kSsimWindowRadius];

  size_t i = 0;
  for (; i < whole; i += lanes) {
    BlurAcross(wide, rendered, target, window, i, scratch, stride);
  }
  for (; i < n; ++i) {
    BlurAcross(one, rendered, target, window, i, scratch, stride);
  }

  SsimRowSums sums;
  auto difference = hn::Zero(wide);
  auto ssim = hn::Zero(wide);
  for (i = 0; i < whole; i += lanes) {
    difference = hn::Add(
        difference,
        hn::Abs(hn::Sub(hn::LoadU(wide, x + i), hn::LoadU(wide, y + i))));
    ssim = hn::Add(ssim, SsimAt(wide, scratch, stride, window, i, derivatives));
  }
  sums.absolute_difference = hn::GetLane(hn::SumOfLanes(wide, difference));
  sums.ssim = hn::GetLane(hn::SumOfLanes(wide, ssim));
  for (; i < n; ++i) {
    sums.absolute_difference += x[i] < y[i] ? y[i] - x[i] : x[i] - y[i];
    sums.ssim +=
        hn::GetLane(SsimAt(one, scratch, stride, window, i, derivatives));
  }
  return sums;
}

template <class D>
HWY_INLINE void DerivativesAcross(D d,
                                  const SsimDerivativeRows& derivatives,
                                  const SsimWindow& window,
                                  size_t i,
                                  float* scratch,
                                  size_t scratch_row) {
  auto mean = hn::Zero(d);
  auto square = hn::Zero(d);
  auto product = hn::Zero(d);
  for (int k = 0; k < kSsimWindowSize; ++k) {
    const auto w = hn::Set(d, window[k]);
    mean = hn::MulAdd(w, hn::LoadU(d, derivatives.mean[k] + i), mean);
    square = hn::MulAdd(w, hn::LoadU(d, derivatives.square[k] + i), square);
    product = hn::MulAdd(w, hn::LoadU(d, derivatives.product[k] + i), product);
  }
  float* const at = scratch + kSsimRowPadding + i;
  hn::StoreU(mean, d, at);
  hn::StoreU(square, d, at + scratch_row);
  hn::StoreU(product, d, at + 2 * scratch_row);
}

template <class D>
HWY_INLINE void GradientAt(D d,
                           const float* scratch,
                           size_t scratch_row,
                           const SsimWindow& window,
                           size_t i,
                           const float* rendered,
                           const float* target,
                           float l1_factor,
                           float ssim_factor,
                           float* gradient) {
  const auto x = hn::LoadU(d, rendered + i);
  const auto y = hn::LoadU(d, target + i);
  const auto mean = BlurAlong(d, scratch, window, i);
  const auto square = BlurAlong(d, scratch + scratch_row, window, i);
  const auto product = BlurAlong(d, scratch + 2 * scratch_row, window, i);
  const auto ssim =
      hn::MulAdd(hn::Add(x, x), square, hn::MulAdd(y, product, mean));
  const auto zero = hn::Zero(d);
  const auto factor = hn::Set(d, l1_factor);
  const auto above = hn::IfThenElseZero(hn::Gt(x, y), factor);
  const auto below = hn::IfThenElseZero(hn::Lt(x, y), hn::Sub(zero, factor));
  hn::StoreU(hn::MulAdd(hn::Set(d, ssim_factor), ssim, hn::Add(above, below)),
             d,
             gradient + i);
}

void BackwardRow(const SsimDerivativeRows& derivatives,
                 const float* rendered,
                 const float* target,
                 const SsimWindow& window,
                 float l1_factor,
                 float ssim_factor,
                 size_t n,
                 float* scratch,
                 float* gradient) {
  const Wide wide;
  const One one;
  const size_t lanes = hn::Lanes(wide);
  const size_t whole = n - n % lanes;
  const size_t stride = SsimScratchRow(n);
  size_t i = 0;
  for (; i < whole; i += lanes) {
    DerivativesAcross(wide, derivatives, window, i, scratch, stride);
  }
  for (; i < n; ++i) {
    DerivativesAcross(one, derivatives, window, i, scratch, stride);
  }
  const auto gradient_at = [&](auto d, size_t at) HWY_ATTR {
    GradientAt(d,
               scratch,
               stride,
               window,
               at,
               rendered,
               target,
               l1_factor,
               ssim_factor,
               gradient);
  };
  for (i = 0; i < whole; i += lanes) gradient_at(wide, i);
  for (; i < n; ++i) gradient_at(one, i);
}

}  // namespace freegs::splat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace freegs::splat {

HWY_EXPORT(ForwardRow);
HWY_EXPORT(BackwardRow);

SsimRowSums SsimForwardRow(const WindowRows& rendered,
                           const WindowRows& target,
                           const SsimWindow& window,
                           size_t n,
                           float* scratch,
                           const SsimDerivativeRow& derivatives) {
  return HWY_DYNAMIC_DISPATCH(ForwardRow)(
      rendered, target, window, n, scratch, derivatives);
}

void SsimBackwardRow(const SsimDerivativeRows& derivatives,
                     const float* rendered,
                     const float* target,
                     const SsimWindow& window,
                     float l1_factor,
                     float ssim_factor,
                     size_t n,
                     float* scratch,
                     float* gradient) {
  HWY_DYNAMIC_DISPATCH(BackwardRow)
  (derivatives,
   rendered,
   target,
   window,
   l1_factor,
   ssim_factor,
   n,
   scratch,
   gradient);
}

}  // namespace freegs::splat
#endif  // HWY_ONCE
