// SPDX-License-Identifier: BSD-3-Clause

#include "splat/render/tile_kernels.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/render/tile_kernels.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "splat/render/tile_blending-inl.h"

HWY_BEFORE_NAMESPACE();
namespace freegs::splat::HWY_NAMESPACE {

// 1 / x without the slow division, to about 23 bits on x86 and 16 on ARM, whose
// estimate is rougher. Only gradients use it.
HWY_INLINE Vec Reciprocal(Tag d, Vec x) {
  const Vec estimate = hn::ApproximateReciprocal(x);
  return hn::Mul(estimate, hn::NegMulAdd(x, estimate, hn::Set(d, 2.0f)));
}

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

// Makes entry k the dominant one at pixels where its weight is the largest so
// far.
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
              TileDominance* dominance,
              TileBlocks* touched) {
  const Tag d;
  float* HWY_RESTRICT transmittance = pixels->transmittance;
  float* HWY_RESTRICT red = pixels->color[0];
  float* HWY_RESTRICT green = pixels->color[1];
  float* HWY_RESTRICT blue = pixels->color[2];
  ClearTransmittance(task, transmittance);
  std::fill_n(red, 3 * kTilePixels, 0.0f);
  std::fill_n(extras, task.num_extras * kTilePixels, 0.0f);
  if constexpr (kDominance) ClearDominance(dominance);
  return ForEachEntry<Fused>(
      d,
      task,
      0,
      task.count,
      transmittance,
      [&](int64_t k, TileBlocks blocks) HWY_ATTR {
        touched[k] = blocks;
        const Splat& splat = task.splats[task.entries[k]];
        const float* splat_extras =
            task.extras +
            static_cast<size_t>(task.entries[k]) * task.num_extras;
        const Vec r = hn::Set(d, splat.color[0]);
        const Vec g = hn::Set(d, splat.color[1]);
        const Vec b = hn::Set(d, splat.color[2]);
        const auto add = [&](Vec weight, Vec value, float* channel) HWY_ATTR {
          hn::Store(
              hn::MulAdd(weight, value, hn::Load(d, channel)), d, channel);
        };
        BlendBlocks<Fused>(
            d,
            blocks,
            TileSplat(task, splat),
            transmittance,
            [&](int pixel, Vec, Vec, Vec alpha, Vec t, Mask mask) HWY_ATTR {
              const Vec weight =
                  TakeWeight(d, alpha, t, mask, transmittance + pixel);
              add(weight, r, red + pixel);
              add(weight, g, green + pixel);
              add(weight, b, blue + pixel);
              for (int e = 0; e < task.num_extras; ++e) {
                add(weight,
                    hn::Set(d, splat_extras[e]),
                    extras + e * kTilePixels + pixel);
              }
              if constexpr (kDominance) {
                KeepDominant(d, pixel, weight, k, dominance);
              }
            });
      });
}

int64_t BlendTile(const TileTask& task,
                  TilePixels* pixels,
                  float* extras,
                  TileDominance* dominance,
                  TileBlocks* touched) {
  return dominance != nullptr
             ? Blend<true>(task, pixels, extras, dominance, touched)
             : Blend<false>(task, pixels, extras, nullptr, touched);
}

void ContributeTile(const TileTask& task,
                    float* transmittance,
                    TileDominance* dominance,
                    PairContribution* contributions) {
  const Tag d;
  const Vec one = hn::Set(d, 1.0f);
  ClearTransmittance(task, transmittance);
  ClearDominance(dominance);
  const int64_t visited = ForEachEntry<Fused>(
      d,
      task,
      0,
      task.count,
      transmittance,
      [&](int64_t k, TileBlocks blocks) HWY_ATTR {
        Vec weights = hn::Zero(d);
        Vec pixels = hn::Zero(d);
        BlendBlocks<Fused>(
            d,
            blocks,
            TileSplat(task, task.splats[task.entries[k]]),
            transmittance,
            [&](int pixel, Vec, Vec, Vec alpha, Vec t, Mask mask) HWY_ATTR {
              const Vec weight =
                  TakeWeight(d, alpha, t, mask, transmittance + pixel);
              weights = hn::Add(weights, weight);
              pixels = hn::Add(pixels, hn::IfThenElseZero(mask, one));
              KeepDominant(d, pixel, weight, k, dominance);
            });
        contributions[k] = {hn::GetLane(hn::SumOfLanes(d, weights)),
                            hn::GetLane(hn::SumOfLanes(d, pixels))};
      });
  std::fill(
      contributions + visited, contributions + task.count, PairContribution());
}

void VoteTile(const TileTask& task, const int32_t* channels, float* votes) {
  const Tag d;
  alignas(64) float transmittance[kTilePixels];
  ClearTransmittance(task, transmittance);
  ForEachEntry<Fused>(
      d,
      task,
      0,
      task.count,
      transmittance,
      [&](int64_t k, TileBlocks blocks) HWY_ATTR {
        const int32_t channel = channels[k];
        BlendBlocks<Fused>(
            d,
            blocks,
            TileSplat(task, task.splats[task.entries[k]]),
            transmittance,
            [&](int pixel, Vec, Vec, Vec alpha, Vec t, Mask mask) HWY_ATTR {
              const Vec weight =
                  TakeWeight(d, alpha, t, mask, transmittance + pixel);
              if (channel < 0) return;
              float* vote = votes + channel * kTilePixels + pixel;
              hn::Store(hn::Add(weight, hn::Load(d, vote)), d, vote);
            });
      });
}

void BackwardTile(const TileTask& task,
                  std::span<const TileBlocks> touched,
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
  const auto visited = static_cast<int64_t>(touched.size());
  for (int64_t k = 0; k < visited; ++k) {
    const Splat& splat = FetchSplat(task, k);
    const float* splat_extras =
        task.extras + static_cast<size_t>(task.entries[k]) * task.num_extras;
    const Vec r = hn::Set(d, splat.color[0]);
    const Vec g = hn::Set(d, splat.color[1]);
    const Vec b = hn::Set(d, splat.color[2]);
    float* sums = moments + k * stride;
    for (int x = 0; x < task.num_extras; ++x) sums[kMomentStride + x] = 0.0f;
    Vec sum_q = hn::Zero(d), sum_qe = hn::Zero(d), sum_qy = hn::Zero(d);
    Vec sum_qee = hn::Zero(d), sum_qey = hn::Zero(d), sum_qyy = hn::Zero(d);
    Vec sum_r = hn::Zero(d), sum_g = hn::Zero(d), sum_b = hn::Zero(d);
    if (touched[k] == 0) {
      std::fill_n(sums, kMomentStride, 0.0f);
      continue;
    }
    BlendBlocks<Fused>(
        d,
        touched[k],
        TileSplat(task, splat),
        transmittance,
        [&](int pixel, Vec e, Vec dy, Vec alpha, Vec t, Mask mask) HWY_ATTR {
          const Vec weight =
              TakeWeight(d, alpha, t, mask, transmittance + pixel);
          const Vec gr = hn::Load(d, red + pixel);
          const Vec gg = hn::Load(d, green + pixel);
          const Vec gb = hn::Load(d, blue + pixel);
          sum_r = hn::MulAdd(weight, gr, sum_r);
          sum_g = hn::MulAdd(weight, gg, sum_g);
          sum_b = hn::MulAdd(weight, gb, sum_b);
          // The product of the splat's values with dL/dpixel.
          Vec value = hn::MulAdd(gr, r, hn::MulAdd(gg, g, hn::Mul(gb, b)));
          for (int x = 0; x < task.num_extras; ++x) {
            const Vec gx =
                hn::Load(d, extra_gradients + x * kTilePixels + pixel);
            value = hn::MulAdd(gx, hn::Set(d, splat_extras[x]), value);
            sums[kMomentStride + x] +=
                hn::GetLane(hn::SumOfLanes(d, hn::Mul(weight, gx)));
          }
          // The splat dims everything behind it by 1 - alpha. With R the
          // product of what lies behind with dL/dpixel, dL/dalpha = T value - R
          // / (1 - alpha).
          const Vec behind =
              hn::NegMulAdd(weight, value, hn::Load(d, remaining + pixel));
          hn::Store(behind, d, remaining + pixel);
          const Vec d_alpha = hn::NegMulAdd(
              behind, Reciprocal(d, hn::Sub(one, alpha)), hn::Mul(t, value));
          // An alpha that was limited to kMaxAlpha has no derivative.
          const Mask free = hn::And(mask, hn::Lt(alpha, hn::Set(d, kMaxAlpha)));
          const Vec q = hn::IfThenElseZero(free, hn::Mul(d_alpha, alpha));
          const Vec qe = hn::Mul(q, e);
          const Vec qy = hn::Mul(q, dy);
          sum_q = hn::Add(sum_q, q);
          sum_qe = hn::Add(sum_qe, qe);
          sum_qy = hn::Add(sum_qy, qy);
          sum_qee = hn::MulAdd(qe, e, sum_qee);
          sum_qey = hn::MulAdd(qe, dy, sum_qey);
          sum_qyy = hn::MulAdd(qy, dy, sum_qyy);
        });
    StoreSums(d, sum_q, sum_qe, sum_qy, sum_qee, sums);
    StoreSums(d, sum_qey, sum_qyy, sum_r, sum_g, sums + 4);
    sums[8] = hn::GetLane(hn::SumOfLanes(d, sum_b));
  }
  // Entries after the one at which the tile became opaque have no gradient.
  for (int64_t k = visited; k < task.count; ++k) {
    std::fill_n(moments + k * stride, stride, 0.0f);
  }
}

}  // namespace freegs::splat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace freegs::splat {

HWY_EXPORT(BlendTile);
HWY_EXPORT(ContributeTile);
HWY_EXPORT(VoteTile);
HWY_EXPORT(BackwardTile);

int64_t BlendTile(const TileTask& task,
                  TilePixels* pixels,
                  float* extras,
                  TileDominance* dominance,
                  TileBlocks* touched) {
  return HWY_DYNAMIC_DISPATCH(BlendTile)(
      task, pixels, extras, dominance, touched);
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
                  std::span<const TileBlocks> touched,
                  TileGradients* gradients,
                  const float* extra_gradients,
                  float* moments) {
  HWY_DYNAMIC_DISPATCH(BackwardTile)
  (task, touched, gradients, extra_gradients, moments);
}

}  // namespace freegs::splat
#endif  // HWY_ONCE
