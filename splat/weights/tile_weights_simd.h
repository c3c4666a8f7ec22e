// SPDX-License-Identifier: BSD-3-Clause
// The blending weights of one tile as a list, SIMD over pixels; compiled for
// several instruction sets by Highway and chosen at run time.

#ifndef FREEGS_SPLAT_WEIGHTS_TILE_WEIGHTS_SIMD_H_
#define FREEGS_SPLAT_WEIGHTS_TILE_WEIGHTS_SIMD_H_

#include <cstdint>

#include "splat/render/tile_layout.h"

namespace freegs::splat {

// Splats listed at a time: the list of a batch stays in the cache.
constexpr int kWeightBatch = 64;

// Weights above 0 of up to kWeightBatch splats in one tile, splat after splat.
struct alignas(64) TileWeightList {
  // A store of the last vector may touch what lies beyond the list's end.
  static constexpr int kCapacity = kWeightBatch * kTilePixels + 64;

  int32_t count = 0;
  float weight[kCapacity];
  // TilePixel of the pixel + kTilePixels * (list entry - batch's first entry).
  uint32_t place[kCapacity];

  static uint32_t PixelOf(uint32_t place) { return place % kTilePixels; }
  static uint32_t EntryOf(uint32_t place) { return place / kTilePixels; }
};

// Blends the tile's entries [begin, begin + kWeightBatch) as BlendTile does and
// lists their weights. transmittance (256 floats, 64-byte aligned) is carried
// from call to call; begin = 0 overwrites it. Returns the entry to go on with,
// task.count once nothing more is blended.
//
// The same task gives the same list, bit for bit, call after call.
int64_t ListTileWeights(const TileTask& task,
                        int64_t begin,
                        float* transmittance,
                        TileWeightList* list);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_WEIGHTS_TILE_WEIGHTS_SIMD_H_
