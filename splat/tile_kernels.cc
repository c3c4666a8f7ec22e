// SPDX-License-Identifier: BSD-3-Clause

#include "splat/tile_kernels.h"

#include <algorithm>
#include <cmath>

#include <hwy/cache_control.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/tile_kernels.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace freegs::splat::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// At most a block of the tile per vector.
using Tag = hn::CappedTag<float, kBlockSize * kBlockSize>;
using Vec = hn::Vec<Tag>;
using Mask = hn::Mask<Tag>;

constexpr float kLog2E = 1.4426950408889634f;
constexpr float kMinLog2Alpha = -7.994353436858858f;  // log2(1 / 255).

// 2^x for x in [-126, 126], relative error below 2e-7; anything elsewhere. The
// sum with 1.5 * 2^23 has the nearest integer in its lowest bits: shifted to
// the exponent they scale a degree 5 Chebyshev interpolant of 2^f, |f| <= 1/2.
HWY_INLINE Vec FastExp2(Tag d, Vec x) {
  const hn::RebindToSigned<Tag> di;
  const Vec magic = hn::Set(d, 12582912.0f);
  const Vec shifted = hn::Add(x, magic);
  const Vec f = hn::Sub(x, hn::Sub(shifted, magic));
  Vec p = hn::MulAdd(
      f, hn::Set(d, 0.0013390863364533504f), hn::Set(d, 0.009676031918326564f));
  p = hn::MulAdd(p, f, hn::Set(d, 0.05550357114219461f));
  p = hn::MulAdd(p, f, hn::Set(d, 0.24022107485308208f));
  p = hn::MulAdd(p, f, hn::Set(d, 0.6931471880262287f));
  p = hn::MulAdd(p, f, hn::Set(d, 1.0000000754548972f));
  return hn::BitCast(
      d,
      hn::Add(hn::BitCast(di, p), hn::ShiftLeft<23>(hn::BitCast(di, shifted))));
}

// 1 / x to about 23 bits, without the slow division.
HWY_INLINE Vec Reciprocal(Tag d, Vec x) {
  const Vec estimate = hn::ApproximateReciprocal(x);
  return hn::Mul(estimate, hn::NegMulAdd(x, estimate, hn::Set(d, 2.0f)));
}

// A vector covers kColumns x kRows pixels of a block (see TilePixel).
constexpr int kColumns = hn::MaxLanes(Tag()) < kBlockSize
                             ? static_cast<int>(hn::MaxLanes(Tag()))
                             : kBlockSize;
constexpr int kRows = static_cast<int>(hn::MaxLanes(Tag())) / kColumns;

// The pixels of a tile that a splat may touch: rows [y_begin, y_end), columns
// [x_begin, x_end), both beginning with a vector.
struct Span {
  int x_begin, x_end, y_begin, y_end;
};

HWY_INLINE Span SplatSpan(const TileTask& task, const Splat& splat) {
  Span span;
  span.x_begin = std::max(0, splat.x_begin - task.x0) & -kColumns;
  span.x_end = std::min(task.width, splat.x_end - task.x0);
  span.y_begin = std::max(0, splat.y_begin - task.y0) & -kRows;
  span.y_end = std::min(task.height, splat.y_end - task.y0);
  return span;
}

// Calls blend(pixel, dy, alpha, T, mask) for the vectors of pixels where the
// splat may be blended, one column of vectors after another; after each column
// column_end(dx), dx being the same in all of it.
template <class Blend, class ColumnEnd>
HWY_INLINE void ForEachBlended(Tag d,
                               const TileTask& task,
                               const Splat& splat,
                               const float* HWY_RESTRICT transmittance,
                               const Blend& blend,
                               const ColumnEnd& column_end) {
  const hn::RebindToSigned<Tag> di;
  const Span span = SplatSpan(task, splat);
  // log2(alpha) = log2(o) - log2(e) / 2 (xx dx^2 + 2 xy dx dy + yy dy^2), per
  // column as a polynomial in dy.
  const float mean_x = splat.mean_x - static_cast<float>(task.x0) - 0.5f;
  const float mean_y = splat.mean_y - static_cast<float>(task.y0) - 0.5f;
  const auto lane = hn::Iota(di, 0);
  const Vec lane_x = hn::ConvertTo(d, hn::And(lane, hn::Set(di, kColumns - 1)));
  const Vec lane_y =
      hn::Sub(hn::ConvertTo(d, hn::ShiftRight<2>(lane)), hn::Set(d, mean_y));
  const Vec constant = hn::Set(d, -0.5f * kLog2E * splat.conic_yy);
  const Vec min_log2_alpha = hn::Set(d, kMinLog2Alpha);
  const Vec min_transmittance = hn::Set(d, kMinTransmittance);
  for (int x = span.x_begin; x < span.x_end; x += kColumns) {
    const int first = TilePixel(x, 0);
    const Vec dx = hn::Add(lane_x, hn::Set(d, static_cast<float>(x) - mean_x));
    const Vec linear = hn::Mul(hn::Set(d, -kLog2E * splat.conic_xy), dx);
    const Vec base =
        hn::MulAdd(hn::Mul(hn::Set(d, -0.5f * kLog2E * splat.conic_xx), dx),
                   dx,
                   hn::Set(d, splat.log2_opacity));
    for (int y = span.y_begin; y < span.y_end; y += kRows) {
      const int pixel = first + TilePixel(0, y);
      const Vec dy = hn::Add(lane_y, hn::Set(d, static_cast<float>(y)));
      const Vec log2_alpha =
          hn::MulAdd(hn::MulAdd(constant, dy, linear), dy, base);
      const Vec t = hn::Load(d, transmittance + pixel);
      // Empty masks are rare within the box: testing for them costs more.
      const Mask mask = hn::And(hn::Ge(log2_alpha, min_log2_alpha),
                                hn::Ge(t, min_transmittance));
      // Lanes outside the mask may hold anything from here on.
      const Vec alpha = hn::Min(FastExp2(d, log2_alpha), hn::Set(d, kMaxAlpha));
      blend(pixel, dy, alpha, t, mask);
    }
    column_end(dx);
  }
}

struct NoColumnEnd {
  HWY_INLINE void operator()(Vec) const {}
};

// Writes the sums over the lanes of a, b, c, e to out[0..3].
template <class D, class V>
HWY_INLINE void StoreSums(D d, V a, V b, V c, V e, float* out) {
#if HWY_TARGET == HWY_SCALAR
  hn::Store(a, d, out);
  hn::Store(b, d, out + 1);
  hn::Store(c, d, out + 2);
  hn::Store(e, d, out + 3);
#else
  // Within each block of four lanes: transpose and add.
  const hn::Repartition<uint64_t, D> pairs;
  const auto ab = hn::BitCast(
      pairs,
      hn::Add(hn::InterleaveLower(d, a, b), hn::InterleaveUpper(d, a, b)));
  const auto ce = hn::BitCast(
      pairs,
      hn::Add(hn::InterleaveLower(d, c, e), hn::InterleaveUpper(d, c, e)));
  const V sums = hn::Add(hn::BitCast(d, hn::InterleaveLower(pairs, ab, ce)),
                         hn::BitCast(d, hn::InterleaveUpper(pairs, ab, ce)));
  // Then over the blocks.
  const hn::CappedTag<float, 4> d4;
  if constexpr (hn::MaxLanes(d) == 16) {
    const hn::Half<D> d8;
    const auto half = hn::Add(hn::LowerHalf(d8, sums), hn::UpperHalf(d8, sums));
    hn::StoreU(
        hn::Add(hn::LowerHalf(d4, half), hn::UpperHalf(d4, half)), d4, out);
  } else if constexpr (hn::MaxLanes(d) == 8) {
    hn::StoreU(
        hn::Add(hn::LowerHalf(d4, sums), hn::UpperHalf(d4, sums)), d4, out);
  } else {
    static_assert(hn::MaxLanes(d) == 4);
    hn::StoreU(sums, d4, out);
  }
#endif
}

// A tile's splats lie scattered over the view's: ask for them ahead of time.
constexpr int64_t kPrefetchDistance = 8;
HWY_INLINE const Splat& FetchSplat(const TileTask& task, int64_t k) {
  const int64_t ahead = std::min(k + kPrefetchDistance, task.count - 1);
  hwy::Prefetch(&task.splats[task.entries[ahead]]);
  return task.splats[task.entries[k]];
}

// Whether no pixel can take more.
HWY_INLINE bool Opaque(Tag d, const float* HWY_RESTRICT transmittance) {
  Vec most = hn::Zero(d);
  for (size_t i = 0; i < kTilePixels; i += hn::Lanes(d)) {
    most = hn::Max(most, hn::Load(d, transmittance + i));
  }
  return hn::AllTrue(d, hn::Lt(most, hn::Set(d, kMinTransmittance)));
}

// Testing for opacity costs a pass over the tile: do it now and then.
constexpr int64_t kOpaqueTestInterval = 16;

void ClearTransmittance(const TileTask& task, float* transmittance) {
  for (int y = 0; y < kTileSize; ++y) {
    for (int x = 0; x < kTileSize; ++x) {
      transmittance[TilePixel(x, y)] =
          x < task.width && y < task.height ? 1.0f : 0.0f;
    }
  }
}

// Remembers entry k where its weight is the largest so far.
HWY_INLINE void KeepDominant(
    Tag d, int pixel, Vec weight, int64_t k, TileDominance* dominance) {
  const hn::RebindToSigned<Tag> di;
  float* best = dominance->weight + pixel;
  const Mask better = hn::Gt(weight, hn::Load(d, best));
  hn::BlendedStore(weight, better, d, best);
  hn::BlendedStore(hn::Set(di, static_cast<int32_t>(k)),
                   hn::RebindMask(di, better),
                   di,
                   dominance->entry + pixel);
}

void ClearDominance(TileDominance* dominance) {
  std::fill_n(dominance->weight, kTilePixels, 0.0f);
  std::fill_n(dominance->entry, kTilePixels, -1);
}

template <bool kDominance>
int64_t Blend(const TileTask& task,
              TilePixels* pixels,
              float* extras,
              TileDominance* dominance) {
  const Tag d;
  float* HWY_RESTRICT transmittance = pixels->transmittance;
  float* HWY_RESTRICT red = pixels->color[0];
  float* HWY_RESTRICT green = pixels->color[1];
  float* HWY_RESTRICT blue = pixels->color[2];
  ClearTransmittance(task, transmittance);
  std::fill_n(red, 3 * kTilePixels, 0.0f);
  std::fill_n(extras, task.num_extras * kTilePixels, 0.0f);
  if constexpr (kDominance) ClearDominance(dominance);
  for (int64_t k = 0; k < task.count; ++k) {
    if (k % kOpaqueTestInterval == 0 && Opaque(d, transmittance)) return k;
    const Splat& splat = FetchSplat(task, k);
    const float* splat_extras =
        task.extras + static_cast<size_t>(task.entries[k]) * task.num_extras;
    const Vec r = hn::Set(d, splat.color[0]);
    const Vec g = hn::Set(d, splat.color[1]);
    const Vec b = hn::Set(d, splat.color[2]);
    ForEachBlended(
        d,
        task,
        splat,
        transmittance,
        [&](int pixel, Vec, Vec alpha, Vec t, Mask mask) HWY_ATTR {
          const Vec weight = hn::IfThenElseZero(mask, hn::Mul(alpha, t));
          hn::Store(hn::Sub(t, weight), d, transmittance + pixel);
          hn::Store(
              hn::MulAdd(weight, r, hn::Load(d, red + pixel)), d, red + pixel);
          hn::Store(hn::MulAdd(weight, g, hn::Load(d, green + pixel)),
                    d,
                    green + pixel);
          hn::Store(hn::MulAdd(weight, b, hn::Load(d, blue + pixel)),
                    d,
                    blue + pixel);
          for (int e = 0; e < task.num_extras; ++e) {
            float* channel = extras + e * kTilePixels + pixel;
            hn::Store(
                hn::MulAdd(
                    weight, hn::Set(d, splat_extras[e]), hn::Load(d, channel)),
                d,
                channel);
          }
          if constexpr (kDominance) {
            KeepDominant(d, pixel, weight, k, dominance);
          }
        },
        NoColumnEnd());
  }
  return task.count;
}

int64_t BlendTile(const TileTask& task,
                  TilePixels* pixels,
                  float* extras,
                  TileDominance* dominance) {
  return dominance != nullptr ? Blend<true>(task, pixels, extras, dominance)
                              : Blend<false>(task, pixels, extras, nullptr);
}

void ContributeTile(const TileTask& task,
                    float* transmittance,
                    TileDominance* dominance,
                    PairContribution* contributions) {
  const Tag d;
  const Vec one = hn::Set(d, 1.0f);
  ClearTransmittance(task, transmittance);
  ClearDominance(dominance);
  for (int64_t k = 0; k < task.count; ++k) {
    Vec weights = hn::Zero(d);
    Vec pixels = hn::Zero(d);
    ForEachBlended(
        d,
        task,
        FetchSplat(task, k),
        transmittance,
        [&](int pixel, Vec, Vec alpha, Vec t, Mask mask) HWY_ATTR {
          const Vec weight = hn::IfThenElseZero(mask, hn::Mul(alpha, t));
          hn::Store(hn::Sub(t, weight), d, transmittance + pixel);
          weights = hn::Add(weights, weight);
          pixels = hn::Add(pixels, hn::IfThenElseZero(mask, one));
          KeepDominant(d, pixel, weight, k, dominance);
        },
        NoColumnEnd());
    contributions[k] = {hn::GetLane(hn::SumOfLanes(d, weights)),
                        hn::GetLane(hn::SumOfLanes(d, pixels))};
  }
}

void VoteTile(const TileTask& task, const int32_t* channels, float* votes) {
  const Tag d;
  alignas(64) float transmittance[kTilePixels];
  ClearTransmittance(task, transmittance);
  for (int64_t k = 0; k < task.count; ++k) {
    if (k % kOpaqueTestInterval == 0 && Opaque(d, transmittance)) return;
    const int32_t channel = channels[k];
    ForEachBlended(
        d,
        task,
        FetchSplat(task, k),
        transmittance,
        [&](int pixel, Vec, Vec alpha, Vec t, Mask mask) HWY_ATTR {
          const Vec weight = hn::IfThenElseZero(mask, hn::Mul(alpha, t));
          hn::Store(hn::Sub(t, weight), d, transmittance + pixel);
          if (channel < 0) return;
          float* vote = votes + channel * kTilePixels + pixel;
          hn::Store(hn::Add(weight, hn::Load(d, vote)), d, vote);
        },
        NoColumnEnd());
  }
}

void BackwardTile(const TileTask& task,
                  int64_t visited,
                  TileGradients* gradients,
                  const float* extra_gradients,
                  float* moments) {
  const Tag d;
  alignas(64) float transmittance[kTilePixels];
  ClearTransmittance(task, transmittance);
  const float* HWY_RESTRICT red = gradients->color[0];
  const float* HWY_RESTRICT green = gradients->color[1];
  const float* HWY_RESTRICT blue = gradients->color[2];
  float* HWY_RESTRICT remaining = gradients->remaining;
  const size_t stride = kMomentStride + task.num_extras;
  const Vec one = hn::Set(d, 1.0f);
  for (int64_t k = 0; k < visited; ++k) {
    const Splat& splat = FetchSplat(task, k);
    const float* splat_extras =
        task.extras + static_cast<size_t>(task.entries[k]) * task.num_extras;
    const Vec r = hn::Set(d, splat.color[0]);
    const Vec g = hn::Set(d, splat.color[1]);
    const Vec b = hn::Set(d, splat.color[2]);
    float* sums = moments + k * stride;
    for (int e = 0; e < task.num_extras; ++e) sums[kMomentStride + e] = 0.0f;
    Vec sum_q = hn::Zero(d), sum_qx = hn::Zero(d), sum_qy = hn::Zero(d);
    Vec sum_qxx = hn::Zero(d), sum_qxy = hn::Zero(d), sum_qyy = hn::Zero(d);
    Vec sum_r = hn::Zero(d), sum_g = hn::Zero(d), sum_b = hn::Zero(d);
    // dx does not change within a column: its powers wait for the column's end.
    Vec column_q = hn::Zero(d), column_qy = hn::Zero(d);
    bool touched = false;
    ForEachBlended(
        d,
        task,
        splat,
        transmittance,
        [&](int pixel, Vec dy, Vec alpha, Vec t, Mask mask) HWY_ATTR {
          touched = true;
          const Vec weight = hn::IfThenElseZero(mask, hn::Mul(alpha, t));
          hn::Store(hn::Sub(t, weight), d, transmittance + pixel);
          const Vec gr = hn::Load(d, red + pixel);
          const Vec gg = hn::Load(d, green + pixel);
          const Vec gb = hn::Load(d, blue + pixel);
          sum_r = hn::MulAdd(weight, gr, sum_r);
          sum_g = hn::MulAdd(weight, gg, sum_g);
          sum_b = hn::MulAdd(weight, gb, sum_b);
          // The splat's own value seen through dL/dpixel.
          Vec value = hn::MulAdd(gr, r, hn::MulAdd(gg, g, hn::Mul(gb, b)));
          for (int e = 0; e < task.num_extras; ++e) {
            const Vec ge =
                hn::Load(d, extra_gradients + e * kTilePixels + pixel);
            value = hn::MulAdd(ge, hn::Set(d, splat_extras[e]), value);
            sums[kMomentStride + e] +=
                hn::GetLane(hn::SumOfLanes(d, hn::Mul(weight, ge)));
          }
          // What lies behind shrinks by (1 - alpha): with R the value still to
          // come, dL/dalpha = T value - R / (1 - alpha).
          const Vec behind =
              hn::NegMulAdd(weight, value, hn::Load(d, remaining + pixel));
          hn::Store(behind, d, remaining + pixel);
          const Vec d_alpha = hn::NegMulAdd(
              behind, Reciprocal(d, hn::Sub(one, alpha)), hn::Mul(t, value));
          // A clamped alpha does not move.
          const Mask free = hn::And(mask, hn::Lt(alpha, hn::Set(d, kMaxAlpha)));
          const Vec q = hn::IfThenElseZero(free, hn::Mul(d_alpha, alpha));
          const Vec qy = hn::Mul(q, dy);
          column_q = hn::Add(column_q, q);
          column_qy = hn::Add(column_qy, qy);
          sum_qyy = hn::MulAdd(qy, dy, sum_qyy);
        },
        [&](Vec dx) HWY_ATTR {
          const Vec qx = hn::Mul(column_q, dx);
          sum_q = hn::Add(sum_q, column_q);
          sum_qx = hn::Add(sum_qx, qx);
          sum_qxx = hn::MulAdd(qx, dx, sum_qxx);
          sum_qy = hn::Add(sum_qy, column_qy);
          sum_qxy = hn::MulAdd(column_qy, dx, sum_qxy);
          column_q = hn::Zero(d);
          column_qy = hn::Zero(d);
        });
    if (!touched) {
      std::fill_n(sums, kMomentStride, 0.0f);
      continue;
    }
    StoreSums(d, sum_q, sum_qx, sum_qy, sum_qxx, sums);
    StoreSums(d, sum_qxy, sum_qyy, sum_r, sum_g, sums + 4);
    sums[8] = hn::GetLane(hn::SumOfLanes(d, sum_b));
  }
  // Entries behind an opaque tile get no gradient.
  for (int64_t k = visited; k < task.count; ++k) {
    std::fill_n(moments + k * stride, stride, 0.0f);
  }
}

const char* TargetName() { return hwy::TargetName(HWY_TARGET); }

}  // namespace freegs::splat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace freegs::splat {

HWY_EXPORT(BlendTile);
HWY_EXPORT(ContributeTile);
HWY_EXPORT(VoteTile);
HWY_EXPORT(BackwardTile);
HWY_EXPORT(TargetName);

int64_t BlendTile(const TileTask& task,
                  TilePixels* pixels,
                  float* extras,
                  TileDominance* dominance) {
  return HWY_DYNAMIC_DISPATCH(BlendTile)(task, pixels, extras, dominance);
}

void ContributeTile(const TileTask& task,
                    float* transmittance,
                    TileDominance* dominance,
                    PairContribution* contributions) {
  HWY_DYNAMIC_DISPATCH(ContributeTile)
  (task, transmittance, dominance, contributions);
}

void VoteTile(const TileTask& task, const int32_t* channels, float* votes) {
  HWY_DYNAMIC_DISPATCH(VoteTile)(task, channels, votes);
}

void BackwardTile(const TileTask& task,
                  int64_t visited,
                  TileGradients* gradients,
                  const float* extra_gradients,
                  float* moments) {
  HWY_DYNAMIC_DISPATCH(BackwardTile)
  (task, visited, gradients, extra_gradients, moments);
}

const char* TileKernelTarget() { return HWY_DYNAMIC_DISPATCH(TargetName)(); }

}  // namespace freegs::splat
#endif  // HWY_ONCE
