// SPDX-License-Identifier: BSD-3-Clause
// The evaluation of alpha for the pixels of a tile, with one pixel per SIMD
// lane. All kernels that walk the splats of a tile from front to back share it.

// Compiled anew for each instruction set: see hwy/highway.h on -inl.h files.
#if defined(FREEGS_SPLAT_RENDER_TILE_BLENDING_INL_H_) == \
    defined(HWY_TARGET_TOGGLE)
#ifdef FREEGS_SPLAT_RENDER_TILE_BLENDING_INL_H_
#undef FREEGS_SPLAT_RENDER_TILE_BLENDING_INL_H_
#else
#define FREEGS_SPLAT_RENDER_TILE_BLENDING_INL_H_
#endif

#include <algorithm>
#include <cstdint>

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include "splat/render/tile_layout.h"

HWY_BEFORE_NAMESPACE();
namespace freegs::splat::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// A vector holds at most one block of the tile.
using Tag = hn::CappedTag<float, kBlockSize * kBlockSize>;
using Vec = hn::Vec<Tag>;
using Mask = hn::Mask<Tag>;

constexpr float kLog2E = 1.4426950408889634f;
constexpr float kMinLog2Alpha = -7.994353436858858f;  // log2(1 / 255).

// How a b + c is computed. Fused is what the processor does fastest, with one
// rounding where it can. Plain rounds twice everywhere, so that the same bytes
// come out with every instruction set.
struct Fused {
  static HWY_INLINE Vec MulAdd(Vec a, Vec b, Vec c) {
    return hn::MulAdd(a, b, c);
  }
};
struct Plain {
  static HWY_INLINE Vec MulAdd(Vec a, Vec b, Vec c) {
    return hn::Add(hn::Mul(a, b), c);
  }
};

// 2^x with a relative error below 3e-7 for x in [-126, 126]; any value for
// other x. The sum of x and 1.5 * 2^23 has the integer nearest to x in its
// lowest bits. Shifted to the exponent, these bits scale a polynomial of degree
// 5 that interpolates 2^f, |f| <= 1/2, at the Chebyshev nodes.
template <class Arithmetic>
HWY_INLINE Vec FastExp2(Tag d, Vec x) {
  const hn::RebindToSigned<Tag> di;
  const Vec magic = hn::Set(d, 12582912.0f);
  const Vec shifted = hn::Add(x, magic);
  const Vec f = hn::Sub(x, hn::Sub(shifted, magic));
  Vec p = Arithmetic::MulAdd(
      f, hn::Set(d, 0.0013390863364533504f), hn::Set(d, 0.009676031918326564f));
  p = Arithmetic::MulAdd(p, f, hn::Set(d, 0.05550357114219461f));
  p = Arithmetic::MulAdd(p, f, hn::Set(d, 0.24022107485308208f));
  p = Arithmetic::MulAdd(p, f, hn::Set(d, 0.6931471880262287f));
  p = Arithmetic::MulAdd(p, f, hn::Set(d, 1.0000000754548972f));
  return hn::BitCast(
      d,
      hn::Add(hn::BitCast(di, p), hn::ShiftLeft<23>(hn::BitCast(di, shifted))));
}

// A vector covers kColumns x kRows pixels of a block (see TilePixel).
constexpr int kColumns = hn::MaxLanes(Tag()) < kBlockSize
                             ? static_cast<int>(hn::MaxLanes(Tag()))
                             : kBlockSize;
constexpr int kRows = static_cast<int>(hn::MaxLanes(Tag())) / kColumns;

// The pixels of a tile that a splat may touch: rows [y_begin, y_end) and
// columns [x_begin, x_end). Both begin where a vector begins.
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

// Calls blend(pixel, dy, alpha, transmittance, mask) for each vector of pixels
// where the splat may be blended, one column of vectors after another. After
// each column it calls column_end(dx); dx is the same in the whole column.
template <class Arithmetic, class Blend, class ColumnEnd>
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
  const Vec lane_y = hn::ConvertTo(d, hn::ShiftRight<2>(lane));
  const Vec constant = hn::Set(d, -0.5f * kLog2E * splat.conic_yy);
  const Vec min_log2_alpha = hn::Set(d, kMinLog2Alpha);
  const Vec min_transmittance = hn::Set(d, kMinTransmittance);
  for (int x = span.x_begin; x < span.x_end; x += kColumns) {
    const int first = TilePixel(x, 0);
    const Vec dx = hn::Sub(hn::Add(lane_x, hn::Set(d, static_cast<float>(x))),
                           hn::Set(d, mean_x));
    const Vec linear = hn::Mul(hn::Set(d, -kLog2E * splat.conic_xy), dx);
    const Vec base = Arithmetic::MulAdd(
        hn::Mul(hn::Set(d, -0.5f * kLog2E * splat.conic_xx), dx),
        dx,
        hn::Set(d, splat.log2_opacity));
    for (int y = span.y_begin; y < span.y_end; y += kRows) {
      const int pixel = first + TilePixel(0, y);
      const Vec dy = hn::Sub(hn::Add(lane_y, hn::Set(d, static_cast<float>(y))),
                             hn::Set(d, mean_y));
      const Vec log2_alpha = Arithmetic::MulAdd(
          Arithmetic::MulAdd(constant, dy, linear), dy, base);
      const Vec t = hn::Load(d, transmittance + pixel);
      // Empty masks are rare within the box: testing for them costs more.
      const Mask mask = hn::And(hn::Ge(log2_alpha, min_log2_alpha),
                                hn::Ge(t, min_transmittance));
      // Lanes outside the mask may hold anything from here on.
      const Vec alpha =
          hn::Min(FastExp2<Arithmetic>(d, log2_alpha), hn::Set(d, kMaxAlpha));
      blend(pixel, dy, alpha, t, mask);
    }
    column_end(dx);
  }
}

struct NoColumnEnd {
  HWY_INLINE void operator()(Vec) const {}
};

// The splats of a tile lie scattered in memory, so they are requested so many
// entries ahead.
constexpr int64_t kPrefetchDistance = 8;
HWY_INLINE const Splat& FetchSplat(const TileTask& task, int64_t k) {
  const int64_t ahead = std::min(k + kPrefetchDistance, task.count - 1);
  hwy::Prefetch(&task.splats[task.entries[ahead]]);
  return task.splats[task.entries[k]];
}

// Whether every pixel is so opaque that nothing more is blended into it.
HWY_INLINE bool Opaque(Tag d, const float* HWY_RESTRICT transmittance) {
  Vec most = hn::Zero(d);
  for (size_t i = 0; i < kTilePixels; i += hn::Lanes(d)) {
    most = hn::Max(most, hn::Load(d, transmittance + i));
  }
  return hn::AllTrue(d, hn::Lt(most, hn::Set(d, kMinTransmittance)));
}

// Testing for opacity costs a pass over the tile, so it is done once in so many
// entries.
constexpr int64_t kOpaqueTestInterval = 16;

HWY_INLINE void ClearTransmittance(const TileTask& task, float* transmittance) {
  for (int y = 0; y < kTileSize; ++y) {
    for (int x = 0; x < kTileSize; ++x) {
      transmittance[TilePixel(x, y)] =
          x < task.width && y < task.height ? 1.0f : 0.0f;
    }
  }
}

}  // namespace freegs::splat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // FREEGS_SPLAT_RENDER_TILE_BLENDING_INL_H_
