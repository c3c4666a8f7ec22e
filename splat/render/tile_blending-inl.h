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
#include <bit>
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

inline constexpr float kLog2E = 1.4426950408889634f;

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

// The x or y of each pixel of the tile, in the order of TilePixel.
struct alignas(64) PixelCoordinates {
  float x[kTilePixels], y[kTilePixels];
};
constexpr PixelCoordinates MakePixelCoordinates() {
  PixelCoordinates coordinates{};
  for (int y = 0; y < kTileSize; ++y) {
    for (int x = 0; x < kTileSize; ++x) {
      const int pixel =
          TilePixel(static_cast<unsigned>(x), static_cast<unsigned>(y));
      coordinates.x[pixel] = static_cast<float>(x);
      coordinates.y[pixel] = static_cast<float>(y);
    }
  }
  return coordinates;
}
inline constexpr PixelCoordinates kPixelCoordinates = MakePixelCoordinates();

// The top-left pixel of each block.
struct alignas(64) BlockCorners {
  float x[kNumBlocks], y[kNumBlocks];
};
constexpr BlockCorners MakeBlockCorners() {
  BlockCorners corners{};
  for (int b = 0; b < kNumBlocks; ++b) {
    corners.x[b] = kPixelCoordinates.x[b * kBlockPixels];
    corners.y[b] = kPixelCoordinates.y[b * kBlockPixels];
  }
  return corners;
}
inline constexpr BlockCorners kBlockCorners = MakeBlockCorners();

// A splat, seen from the top-left pixel of a tile.
struct TileSplat {
  HWY_INLINE TileSplat(const TileTask& task, const Splat& splat)
      : mean_x(splat.mean_x - static_cast<float>(task.x0) - 0.5f),
        mean_y(splat.mean_y - static_cast<float>(task.y0) - 0.5f),
        xx(-0.5f * kLog2E * splat.conic_xx),
        shear(splat.shear),
        yy(-0.5f * kLog2E * splat.precision_y),
        log2_opacity(splat.log2_opacity) {}

  // log2(alpha) = log2_opacity + xx (dx + shear dy)^2 + yy dy^2, where xx and
  // yy are not positive. So alpha is never above the opacity.
  float mean_x, mean_y;
  float xx, shear, yy;
  float log2_opacity;
};

// The blocks in which alpha may reach kMinAlpha at a pixel.
//
// In the rectangle of a block's pixel centres alpha is largest at the mean, if
// that is inside, or else on one of the at most two sides that face the mean.
// On such a side log2(alpha) is a parabola, whose top is clamped to the side.
// kSlack makes up for rounding, except for splats of 100 000 pixels and more,
// for which the Arithmetic decides, too.
template <class Arithmetic>
HWY_INLINE TileBlocks TouchedBlocks(Tag d, const TileSplat& splat) {
  constexpr float kSlack = 0.01f;
  const Vec zero = hn::Zero(d);
  const Vec side = hn::Set(d, static_cast<float>(kBlockSize - 1));
  const Vec xx = hn::Set(d, splat.xx);
  const Vec shear = hn::Set(d, splat.shear);
  const Vec yy = hn::Set(d, splat.yy);
  // Where the derivative along a column is 0: dy = y_of_x dx.
  const float sheared = splat.xx * splat.shear;
  const Vec y_of_x = hn::Set(d, -sheared / (sheared * splat.shear + splat.yy));
  const Vec x_of_y = hn::Set(d, -splat.shear);
  const Vec least = hn::Set(d, kMinLog2Alpha - kSlack - splat.log2_opacity);
  TileBlocks blocks = 0;
  for (size_t b = 0; b < kNumBlocks; b += hn::Lanes(d)) {
    const Vec left =
        hn::Sub(hn::Load(d, kBlockCorners.x + b), hn::Set(d, splat.mean_x));
    const Vec top =
        hn::Sub(hn::Load(d, kBlockCorners.y + b), hn::Set(d, splat.mean_y));
    const Vec right = hn::Add(left, side);
    const Vec bottom = hn::Add(top, side);
    const Vec near_x = hn::Max(left, hn::Min(right, zero));
    const Vec near_y = hn::Max(top, hn::Min(bottom, zero));
    const auto reaches = [&](Vec dx, Vec dy) HWY_ATTR {
      const Vec t = Arithmetic::MulAdd(shear, dy, dx);
      const Vec log2_alpha =
          Arithmetic::MulAdd(hn::Mul(xx, t), t, hn::Mul(hn::Mul(yy, dy), dy));
      return hn::Ge(log2_alpha, least);
    };
    const Mask touched = hn::Or(
        reaches(near_x, hn::Max(top, hn::Min(bottom, hn::Mul(y_of_x, near_x)))),
        reaches(hn::Max(left, hn::Min(right, hn::Mul(x_of_y, near_y))),
                near_y));
    uint8_t bits[8] = {};
    hn::StoreMaskBits(d, touched, bits);
    blocks |= (static_cast<TileBlocks>(bits[0]) |
               static_cast<TileBlocks>(bits[1]) << 8)
              << b;
  }
  return blocks;
}

// The blocks with a pixel into which more can be blended.
HWY_INLINE TileBlocks OpenBlocks(Tag d,
                                 const float* HWY_RESTRICT transmittance) {
  const Vec least = hn::Set(d, kMinTransmittance);
  TileBlocks blocks = 0;
  for (int b = 0; b < kNumBlocks; ++b) {
    Vec most = hn::Load(d, transmittance + b * kBlockPixels);
    for (size_t i = hn::Lanes(d); i < kBlockPixels; i += hn::Lanes(d)) {
      most = hn::Max(most, hn::Load(d, transmittance + b * kBlockPixels + i));
    }
    const bool open = !hn::AllFalse(d, hn::Ge(most, least));
    blocks |= static_cast<TileBlocks>(open) << b;
  }
  return blocks;
}

// The splats of a tile lie scattered in memory, so they are requested so many
// entries ahead.
inline constexpr int64_t kPrefetchDistance = 8;
HWY_INLINE const Splat& FetchSplat(const TileTask& task, int64_t k) {
  const int64_t ahead = std::min(k + kPrefetchDistance, task.count - 1);
  hwy::Prefetch(&task.splats[task.entries[ahead]]);
  return task.splats[task.entries[k]];
}

// The weights with which a splat is blended into a vector of pixels, 0 outside
// the mask. Lowers the pixels' transmittance, which was `t`.
HWY_INLINE Vec TakeWeight(
    Tag d, Vec alpha, Vec t, Mask mask, float* HWY_RESTRICT transmittance) {
  const Vec weight = hn::IfThenElseZero(mask, hn::Mul(alpha, t));
  hn::Store(hn::Sub(t, weight), d, transmittance);
  return weight;
}

// Calls blend(pixel, dx + shear dy, dy, alpha, transmittance, mask) for each
// vector of pixels of `blocks`.
template <class Arithmetic, class Blend>
HWY_INLINE void BlendBlocks(Tag d,
                            TileBlocks blocks,
                            const TileSplat& splat,
                            const float* HWY_RESTRICT transmittance,
                            const Blend& blend) {
  const Vec mean_x = hn::Set(d, splat.mean_x);
  const Vec mean_y = hn::Set(d, splat.mean_y);
  const Vec xx = hn::Set(d, splat.xx);
  const Vec shear = hn::Set(d, splat.shear);
  const Vec yy = hn::Set(d, splat.yy);
  const Vec log2_opacity = hn::Set(d, splat.log2_opacity);
  const Vec min_log2_alpha = hn::Set(d, kMinLog2Alpha);
  const Vec min_transmittance = hn::Set(d, kMinTransmittance);
  for (; blocks != 0; blocks &= blocks - 1) {
    const int first = std::countr_zero(blocks) * kBlockPixels;
    for (int pixel = first; pixel < first + kBlockPixels;
         pixel += static_cast<int>(hn::Lanes(d))) {
      const Vec dx = hn::Sub(hn::Load(d, kPixelCoordinates.x + pixel), mean_x);
      const Vec dy = hn::Sub(hn::Load(d, kPixelCoordinates.y + pixel), mean_y);
      const Vec sheared = Arithmetic::MulAdd(shear, dy, dx);
      const Vec base = Arithmetic::MulAdd(hn::Mul(yy, dy), dy, log2_opacity);
      const Vec log2_alpha =
          Arithmetic::MulAdd(hn::Mul(xx, sheared), sheared, base);
      const Vec t = hn::Load(d, transmittance + pixel);
      const Mask mask = hn::And(hn::Ge(log2_alpha, min_log2_alpha),
                                hn::Ge(t, min_transmittance));
      // Lanes outside the mask may hold anything from here on.
      const Vec alpha =
          hn::Min(FastExp2<Arithmetic>(d, log2_alpha), hn::Set(d, kMaxAlpha));
      blend(pixel, sheared, dy, alpha, t, mask);
    }
  }
}

// Entries are taken in batches. Finding the open blocks costs a pass over the
// tile, so it is done once in a batch. The blocks that the splats of a batch
// touch are found before any of them is blended: how many blocks a splat
// touches is a branch that the processor mostly predicts wrongly, and then it
// would have to wait for the long chain of operations that finds the next ones.
inline constexpr int64_t kBatch = 16;

// Calls visit(k, blocks) for the entries [begin, end), from front to back,
// until no block is open. `blocks` are those that entry k may be blended into;
// visit lowers the transmittance. Returns the first entry that was not visited.
template <class Arithmetic, class Visit>
HWY_INLINE int64_t ForEachEntry(Tag d,
                                const TileTask& task,
                                int64_t begin,
                                int64_t end,
                                const float* transmittance,
                                const Visit& visit) {
  TileBlocks touched[kBatch];
  for (int64_t first = begin; first < end; first += kBatch) {
    const TileBlocks open = OpenBlocks(d, transmittance);
    if (open == 0) return first;
    const int64_t last = std::min(first + kBatch, end);
    for (int64_t k = first; k < last; ++k) {
      const TileSplat splat(task, FetchSplat(task, k));
      touched[k - first] = open & TouchedBlocks<Arithmetic>(d, splat);
    }
    for (int64_t k = first; k < last; ++k) visit(k, touched[k - first]);
  }
  return end;
}

HWY_INLINE void ClearTransmittance(const TileTask& task, float* transmittance) {
  for (int y = 0; y < kTileSize; ++y) {
    for (int x = 0; x < kTileSize; ++x) {
      const bool used =
          x < task.width && y < task.height &&
          (task.mask == nullptr || (*task.mask)(task.x0 + x, task.y0 + y) != 0);
      transmittance[TilePixel(x, y)] = used ? 1.0f : 0.0f;
    }
  }
}

}  // namespace freegs::splat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // FREEGS_SPLAT_RENDER_TILE_BLENDING_INL_H_
