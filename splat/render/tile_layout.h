// SPDX-License-Identifier: BSD-3-Clause
// The inputs and outputs of the kernels of one tile: its pixels, its list of
// splats and its gradients.

#ifndef FREEGS_SPLAT_RENDER_TILE_LAYOUT_H_
#define FREEGS_SPLAT_RENDER_TILE_LAYOUT_H_

#include <cstdint>

#include "core/image.h"
#include "splat/projection/splat.h"

namespace freegs::splat {

inline constexpr int kTileSize = 16;
inline constexpr int kTilePixels = kTileSize * kTileSize;

// A tile's pixels are stored in blocks of 4 x 4. The blocks are in row-major
// order, and so are the pixels of a block. A small splat touches fewer vectors
// this way than if vectors were parts of long rows.
inline constexpr int kBlockSize = 4;
inline constexpr int kBlockPixels = kBlockSize * kBlockSize;
inline constexpr int kNumBlocks = kTilePixels / kBlockPixels;
constexpr int TilePixel(unsigned x, unsigned y) {
  const unsigned block =
      y / kBlockSize * (kTileSize / kBlockSize) + x / kBlockSize;
  return static_cast<int>(block * kBlockPixels + y % kBlockSize * kBlockSize +
                          x % kBlockSize);
}

// A set of the tile's blocks: bit b is the block whose pixels begin at
// b * kBlockPixels.
using TileBlocks = uint32_t;

// The work of one tile.
struct TileTask {
  const Splat* splats = nullptr;      // The splat of each Gaussian.
  const uint32_t* entries = nullptr;  // The tile's Gaussians, by depth.
  int64_t count = 0;
  int x0 = 0, y0 = 0;         // Top-left pixel.
  int width = 0, height = 0;  // Pixels inside the image, at most 16 each.
  // A mask of the size of the image: nothing is blended where it is 0. Null:
  // everywhere is blended.
  const ImageU8* mask = nullptr;
  // Extra values per Gaussian: num_extras floats each.
  const float* extras = nullptr;
  int num_extras = 0;
};

// What blending accumulates. Pixels outside the image have transmittance 0, so
// nothing is blended into them.
struct alignas(64) TilePixels {
  float transmittance[kTilePixels];
  float color[3][kTilePixels];
};

// The largest weight of all splats at each pixel and the list entry it belongs
// to: the nearest of several, 0 and -1 where nothing was blended.
struct alignas(64) TileDominance {
  float weight[kTilePixels];
  int32_t entry[kTilePixels];
};

// What one splat contributes to one tile: the sum of its weights, and the
// number of pixels it was blended into.
struct PairContribution {
  float weight_sum;
  float num_pixels;
};

// The derivatives of the loss L with respect to a tile's pixels.
struct alignas(64) TileGradients {
  float color[3][kTilePixels];  // dL/dcolor, 0 outside the image.
  // sum_c dL/dcolor_c * color_c + sum_e dL/dextra_e * extra_e + dL/dT * T of
  // the finished pixel, with the background in color_c.
  float remaining[kTilePixels];
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_RENDER_TILE_LAYOUT_H_
