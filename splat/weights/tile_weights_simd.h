// SPDX-License-Identifier: BSD-3-Clause
// The blending weights of one tile as a list, with one pixel per SIMD lane.
// Highway compiles the code for several instruction sets and chooses one at run
// time.

#ifndef FREEGS_SPLAT_WEIGHTS_TILE_WEIGHTS_SIMD_H_
#define FREEGS_SPLAT_WEIGHTS_TILE_WEIGHTS_SIMD_H_

#include <cstdint>

#include "splat/render/tile_layout.h"

namespace freegs::splat {

// Splats per call of ListTileWeights. The list of so many stays in the cache.
inline constexpr int kWeightBatch = 64;

// The weights above 0 of up to kWeightBatch splats in one tile, splat after
// splat.
struct alignas(64) TileWeightList {
  // Room for all weights, and for the lanes that the store of the last vector
  // may write beyond the end of the list.
  static constexpr int kCapacity = kWeightBatch * kTilePixels + 64;

  int32_t count = 0;
  float weight[kCapacity];
  // TilePixel of the pixel + kTilePixels * (entry - first entry of the batch).
  uint32_t place[kCapacity];

  static uint32_t PixelOf(uint32_t place) { return place % kTilePixels; }
  static uint32_t EntryOf(uint32_t place) { return place / kTilePixels; }
};

// Blends the tile's entries [begin, begin + kWeightBatch) as BlendTile does and
// lists their weights. transmittance (256 floats, 64-byte aligned) must be kept
// from one call to the next; a call with begin = 0 initialises it. Returns the
// entry to go on with, or task.count when nothing more will be blended.
//
// The same task always gives the same list, bit for bit, with any instruction
// set.
int64_t ListTileWeights(const TileTask& task,
                        int64_t begin,
                        float* transmittance,
                        TileWeightList* list);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_WEIGHTS_TILE_WEIGHTS_SIMD_H_
