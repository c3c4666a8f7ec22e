// SPDX-License-Identifier: BSD-3-Clause
// What the kernels of a tile read and write: its pixels, its list of splats,
// its gradients.

#ifndef FREEGS_SPLAT_RENDER_TILE_LAYOUT_H_
#define FREEGS_SPLAT_RENDER_TILE_LAYOUT_H_

#include <cstdint>

#include "splat/projection/splat.h"

namespace freegs::splat {

constexpr int kTileSize = 16;
constexpr int kTilePixels = kTileSize * kTileSize;

// A tile's pixels are kept in blocks of 4 x 4, row-major, and so are the pixels
// of a block: a small splat meets fewer vectors than with long rows.
constexpr int kBlockSize = 4;
constexpr int TilePixel(unsigned x, unsigned y) {
  const unsigned block =
      y / kBlockSize * (kTileSize / kBlockSize) + x / kBlockSize;
  return static_cast<int>(block * kBlockSize * kBlockSize +
                          y % kBlockSize * kBlockSize + x % kBlockSize);
}

// The work of one tile.
struct TileTask {
  const Splat* splats = nullptr;      // All splats of the view, by depth.
  const uint32_t* entries = nullptr;  // The tile's list: indices into splats.
  int64_t count = 0;
  int x0 = 0, y0 = 0;         // Top-left pixel.
  int width = 0, height = 0;  // Pixels inside the image, at most 16 each.
  // Extra values per splat, in the order of splats: num_extras floats each.
  const float* extras = nullptr;
  int num_extras = 0;
};

// What a tile accumulates. Outside the image transmittance is 0.
struct alignas(64) TilePixels {
  float transmittance[kTilePixels];
  float color[3][kTilePixels];
};

// Per pixel the largest weight of all splats and the list entry it belongs to
// (0 and -1 where nothing was blended; ties go to the nearest).
struct alignas(64) TileDominance {
  float weight[kTilePixels];
  int32_t entry[kTilePixels];
};

// What one splat gives to one tile: the sum of its weights and the number of
// pixels it was blended into.
struct PairContribution {
  float weight_sum;
  float num_pixels;
};

struct alignas(64) TileGradients {
  float color[3][kTilePixels];  // dL/dcolor per pixel, 0 outside the image.
  // sum_c dL/dcolor_c * color_c + sum_e dL/dextra_e * extra_e +
  // dL/dT * T of the finished pixel, background included.
  float remaining[kTilePixels];
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_RENDER_TILE_LAYOUT_H_
