// SPDX-License-Identifier: BSD-3-Clause

#include "splat/optim/loss_simd.h"

#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/optim/loss_simd.cc"
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

// The window's weights, each in all lanes.
template <class D>
struct Weights {
  HWY_INLINE Weights(D d, const SsimWindow& window) {
    for (int k = 0; k <= kSsimWindowRadius; ++k)
      half[k] = hn::Set(d, window[k]);
  }
  // The window is symmetric.
  template <int kOffset>
  HWY_INLINE hn::Vec<D> At() const {
    constexpr int kMirrored = kSsimWindowSize - 1 - kOffset;
    return half[kOffset < kMirrored ? kOffset : kMirrored];
  }
  hn::Vec<D> half[kSsimWindowRadius + 1];
};

// Sums over the window of each row of a block.
template <class D>
struct BlockSums {
  HWY_INLINE explicit BlockSums(D d) {
    for (auto& row : rows) row = hn::Zero(d);
  }
  // Adds input row kInput, of this value, to the rows whose windows hold it.
  template <int kInput, int kRow = 0>
  HWY_INLINE void Add(const Weights<D>& weights, hn::Vec<D> value) {
    constexpr int kOffset = kInput - kRow;
    if constexpr (kOffset >= 0 && kOffset < kSsimWindowSize) {
      rows[kRow] =
          hn::MulAdd(weights.template At<kOffset>(), value, rows[kRow]);
    }
    if constexpr (kRow + 1 < kSsimBlockRows) {
      Add<kInput, kRow + 1>(weights, value);
    }
  }
  // Row r goes to at + r * row_stride.
  HWY_INLINE void Store(D d, float* at, size_t row_stride) const {
    for (int r = 0; r < kSsimBlockRows; ++r) {
      hn::StoreU(rows[r], d, at + r * row_stride);
    }
  }
  hn::Vec<D> rows[kSsimBlockRows];
};

// E[x], E[y], E[x^2 + y^2], E[x y]. SSIM needs the squares' sum only.
template <class D>
struct Moments {
  HWY_INLINE explicit Moments(D d) : x(d), y(d), squares(d), product(d) {}
  template <int kInput = 0>
  HWY_INLINE void AddAll(D d,
                         const WindowRows& rendered,
                         const WindowRows& target,
                         const Weights<D>& weights,
                         size_t i) {
    const auto a = hn::LoadU(d, rendered[kInput] + i);
    const auto b = hn::LoadU(d, target[kInput] + i);
    x.template Add<kInput>(weights, a);
    y.template Add<kInput>(weights, b);
    squares.template Add<kInput>(weights, hn::MulAdd(a, a, hn::Mul(b, b)));
    product.template Add<kInput>(weights, hn::Mul(a, b));
    if constexpr (kInput + 1 < kSsimInputRows) {
      AddAll<kInput + 1>(d, rendered, target, weights, i);
    }
  }
  BlockSums<D> x, y, squares, product;
};

// The scratch rows of one row of the block, one for each kind of moment, lie
// before those of the next.
constexpr int kKinds = 4;

// Blurs across rows: the moments of column i into the scratch rows.
template <class D>
HWY_INLINE void BlurAcross(D d,
                           const WindowRows& rendered,
                           const WindowRows& target,
                           const Weights<D>& weights,
                           size_t i,
                           float* scratch,
                           size_t scratch_row) {
  Moments<D> moments(d);
  moments.AddAll(d, rendered, target, weights, i);
  float* const at = scratch + kSsimRowPadding + i;
  moments.x.Store(d, at, kKinds * scratch_row);
  moments.y.Store(d, at + scratch_row, kKinds * scratch_row);
  moments.squares.Store(d, at + 2 * scratch_row, kKinds * scratch_row);
  moments.product.Store(d, at + 3 * scratch_row, kKinds * scratch_row);
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

// Calls body(tag, i) for i from 0 to n - 1: first vector by vector, then, where
// no whole vector is left, float by float.
template <class Body>
HWY_INLINE void ForEachVector(size_t n, const Body& body) {
  const Wide wide;
  const size_t lanes = hn::Lanes(wide);
  size_t i = 0;
  for (; i + lanes <= n; i += lanes) body(wide, i);
  for (; i < n; ++i) body(One(), i);
}

SsimRowSums ForwardRow(const float* x,
                       const float* y,
                       const SsimWindow& window,
                       size_t n,
                       const float* scratch,
                       const SsimDerivativeRow& derivatives) {
  const Wide wide;
  const size_t lanes = hn::Lanes(wide);
  const size_t stride = SsimScratchRow(n);
  SsimRowSums sums;
  auto difference = hn::Zero(wide);
  auto ssim = hn::Zero(wide);
  size_t i = 0;
  for (; i + lanes <= n; i += lanes) {
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
        hn::GetLane(SsimAt(One(), scratch, stride, window, i, derivatives));
  }
  return sums;
}

void ForwardRows(const WindowRows& rendered,
                 const WindowRows& target,
                 const SsimBlock& block,
                 const SsimDerivativeRow* derivatives,
                 SsimRowSums* sums) {
  const size_t n = block.n;
  const size_t stride = SsimScratchRow(n);
  float* const scratch = block.scratch;
  const Weights<Wide> wide_weights(Wide(), block.window);
  const Weights<One> one_weights(One(), block.window);
  size_t i = 0;
  for (const size_t lanes = hn::Lanes(Wide()); i + lanes <= n; i += lanes) {
    BlurAcross(Wide(), rendered, target, wide_weights, i, scratch, stride);
  }
  for (; i < n; ++i) {
    BlurAcross(One(), rendered, target, one_weights, i, scratch, stride);
  }
  for (int r = 0; r < block.num_rows; ++r) {
    sums[r] = ForwardRow(rendered[kSsimWindowRadius + r],
                         target[kSsimWindowRadius + r],
                         block.window,
                         n,
                         scratch + r * kKinds * stride,
                         derivatives[r]);
  }
}

template <class D>
struct DerivativeSums {
  HWY_INLINE explicit DerivativeSums(D d) : mean(d), square(d), product(d) {}
  template <int kInput = 0>
  HWY_INLINE void AddAll(D d,
                         const SsimDerivativeRows& rows,
                         const Weights<D>& weights,
                         size_t i) {
    mean.template Add<kInput>(weights, hn::LoadU(d, rows.mean[kInput] + i));
    square.template Add<kInput>(weights, hn::LoadU(d, rows.square[kInput] + i));
    product.template Add<kInput>(weights,
                                 hn::LoadU(d, rows.product[kInput] + i));
    if constexpr (kInput + 1 < kSsimInputRows) {
      AddAll<kInput + 1>(d, rows, weights, i);
    }
  }
  BlockSums<D> mean, square, product;
};

template <class D>
HWY_INLINE void DerivativesAcross(D d,
                                  const SsimDerivativeRows& derivatives,
                                  const Weights<D>& weights,
                                  size_t i,
                                  float* scratch,
                                  size_t scratch_row) {
  DerivativeSums<D> sums(d);
  sums.AddAll(d, derivatives, weights, i);
  float* const at = scratch + kSsimRowPadding + i;
  sums.mean.Store(d, at, kKinds * scratch_row);
  sums.square.Store(d, at + scratch_row, kKinds * scratch_row);
  sums.product.Store(d, at + 2 * scratch_row, kKinds * scratch_row);
}

template <class D>
HWY_INLINE void GradientAt(D d,
                           const float* scratch,
                           size_t scratch_row,
                           const SsimWindow& window,
                           size_t i,
                           const float* rendered,
                           const float* target,
                           LossFactors factors,
                           float* gradient) {
  const auto x = hn::LoadU(d, rendered + i);
  const auto y = hn::LoadU(d, target + i);
  const auto mean = BlurAlong(d, scratch, window, i);
  const auto square = BlurAlong(d, scratch + scratch_row, window, i);
  const auto product = BlurAlong(d, scratch + 2 * scratch_row, window, i);
  const auto ssim =
      hn::MulAdd(hn::Add(x, x), square, hn::MulAdd(y, product, mean));
  const auto zero = hn::Zero(d);
  const auto factor = hn::Set(d, factors.l1);
  const auto above = hn::IfThenElseZero(hn::Gt(x, y), factor);
  const auto below = hn::IfThenElseZero(hn::Lt(x, y), hn::Sub(zero, factor));
  hn::StoreU(hn::MulAdd(hn::Set(d, factors.ssim), ssim, hn::Add(above, below)),
             d,
             gradient + i);
}

void BackwardRows(const SsimDerivativeRows& derivatives,
                  const float* rendered,
                  const float* target,
                  const SsimBlock& block,
                  LossFactors factors,
                  float* gradient) {
  const size_t n = block.n;
  const size_t stride = SsimScratchRow(n);
  float* const scratch = block.scratch;
  const Weights<Wide> wide_weights(Wide(), block.window);
  const Weights<One> one_weights(One(), block.window);
  size_t i = 0;
  for (const size_t lanes = hn::Lanes(Wide()); i + lanes <= n; i += lanes) {
    DerivativesAcross(Wide(), derivatives, wide_weights, i, scratch, stride);
  }
  for (; i < n; ++i) {
    DerivativesAcross(One(), derivatives, one_weights, i, scratch, stride);
  }
  for (int r = 0; r < block.num_rows; ++r) {
    ForEachVector(n, [&](auto d, size_t at) HWY_ATTR {
      GradientAt(d,
                 scratch + r * kKinds * stride,
                 stride,
                 block.window,
                 at,
                 rendered + r * n,
                 target + r * n,
                 factors,
                 gradient + r * n);
    });
  }
}

}  // namespace freegs::splat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace freegs::splat {

HWY_EXPORT(ForwardRows);
HWY_EXPORT(BackwardRows);

void SsimForwardRows(const WindowRows& rendered,
                     const WindowRows& target,
                     const SsimBlock& block,
                     const SsimDerivativeRow* derivatives,
                     SsimRowSums* sums) {
  HWY_DYNAMIC_DISPATCH(ForwardRows)
  (rendered, target, block, derivatives, sums);
}

void SsimBackwardRows(const SsimDerivativeRows& derivatives,
                      const float* rendered,
                      const float* target,
                      const SsimBlock& block,
                      LossFactors factors,
                      float* gradient) {
  HWY_DYNAMIC_DISPATCH(BackwardRows)
  (derivatives, rendered, target, block, factors, gradient);
}

}  // namespace freegs::splat
#endif  // HWY_ONCE
