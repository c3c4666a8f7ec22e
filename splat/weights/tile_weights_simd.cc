// SPDX-License-Identifier: BSD-3-Clause

#include "splat/weights/tile_weights_simd.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/weights/tile_weights_simd.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "splat/render/tile_blending-inl.h"

HWY_BEFORE_NAMESPACE();
namespace freegs::splat::HWY_NAMESPACE {

int64_t ListWeights(const TileTask& task,
                    int64_t begin,
                    float* transmittance,
                    TileWeightList* list) {
  const Tag d;
  const hn::RebindToUnsigned<Tag> du;
  if (begin == 0) ClearTransmittance(task, transmittance);
  const int64_t end = std::min<int64_t>(begin + kWeightBatch, task.count);
  const auto lane = hn::Iota(du, 0);
  size_t count = 0;
  list->count = 0;
  const int64_t visited = ForEachEntry<Plain>(
      d,
      task,
      begin,
      end,
      transmittance,
      [&](int64_t k, TileBlocks blocks) HWY_ATTR {
        const auto entry = static_cast<uint32_t>(k - begin) * kTilePixels;
        BlendBlocks<Plain>(
            d,
            blocks,
            TileSplat(task, task.splats[task.entries[k]]),
            transmittance,
            [&](int pixel, Vec, Vec, Vec alpha, Vec t, Mask mask) HWY_ATTR {
              const Vec weight =
                  TakeWeight(d, alpha, t, mask, transmittance + pixel);
              const auto place = hn::Add(
                  lane, hn::Set(du, entry + static_cast<uint32_t>(pixel)));
              hn::CompressStore(weight, mask, d, list->weight + count);
              count += hn::CompressStore(
                  place, hn::RebindMask(du, mask), du, list->place + count);
            });
        list->count = static_cast<int32_t>(count);
      });
  return visited < end ? task.count : end;
}

}  // namespace freegs::splat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace freegs::splat {

HWY_EXPORT(ListWeights);

int64_t ListTileWeights(const TileTask& task,
                        int64_t begin,
                        float* transmittance,
                        TileWeightList* list) {
  return HWY_DYNAMIC_DISPATCH(ListWeights)(task, begin, transmittance, list);
}

}  // namespace freegs::splat
#endif  // HWY_ONCE
