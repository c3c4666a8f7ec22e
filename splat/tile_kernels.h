// SPDX-License-Identifier: BSD-3-Clause
// The inner loops of the rasteriser: alpha blending of depth-ordered splats in
// one tile, forward and backward, SIMD over pixels. Compiled for several
// instruction sets by Highway and chosen at run time.
//
// Blending (Kerbl et al. 2023, eq. 3): alpha_i = min(0.99, o_i exp(-q_i / 2)),
// q_i = d^T conic d, weight w_i = alpha_i T_i, T_{i+1} = T_i (1 - alpha_i).
// Splats with alpha < 1/255, and pixels whose T fell under 1e-4, are skipped.

#ifndef FREEGS_SPLAT_TILE_KERNELS_H_
#define FREEGS_SPLAT_TILE_KERNELS_H_

#include <cstdint>

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

constexpr float kMinAlpha = 1.0f / 255.0f;
constexpr float kMaxAlpha = 0.99f;
constexpr float kMinTransmittance = 1e-4f;

// A projected Gaussian as the kernels read it: one cache line.
struct alignas(64) Splat {
  float mean_x, mean_y;                // Pixels.
  float conic_xx, conic_xy, conic_yy;  // Inverse covariance, 1 / px^2.
  float log2_opacity;                  // <= 0.
  float extent_x, extent_y;            // Half size of the box where alpha may
                                       // reach 1/255, pixels.
  float color[3];
  float depth;
  // That box as pixels of the image: columns [x_begin, x_end) and rows.
  int32_t x_begin, x_end, y_begin, y_end;
};

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

// Blends the list front to back into *pixels and, when task.num_extras > 0,
// into extras[channel * 256 + TilePixel] (64-byte aligned), both overwritten.
// Also fills *dominance unless it is null. Returns how many list entries had
// been visited when the tile was opaque.
int64_t BlendTile(const TileTask& task,
                  TilePixels* pixels,
                  float* extras,
                  TileDominance* dominance = nullptr);

// What one splat gives to one tile: the sum of its weights and the number of
// pixels it was blended into.
struct PairContribution {
  float weight_sum;
  float num_pixels;
};

// Blends weights only: overwrites transmittance (256 floats, 64-byte aligned)
// and *dominance, and writes what list entry k gave to contributions[k].
void ContributeTile(const TileTask& task,
                    float* transmittance,
                    TileDominance* dominance,
                    PairContribution* contributions);

// Adds to votes[channel * 256 + TilePixel] the weight of every splat, where
// channel is channels[k] of list entry k (negative: none).
void VoteTile(const TileTask& task, const int32_t* channels, float* votes);

// Sums over the pixels of a tile that one splat contributes, in this order;
// q = dL/dalpha * alpha and (dx, dy) = pixel centre - mean:
// sum q, q dx, q dy, q dx^2, q dx dy, q dy^2, then dL/dcolor (3), then
// dL/dextra (num_extras).
constexpr int kNumMoments = 6;
constexpr int kMomentStride = kNumMoments + 3;  // + num_extras.

struct alignas(64) TileGradients {
  float color[3][kTilePixels];  // dL/dcolor per pixel, 0 outside the image.
  // sum_c dL/dcolor_c * color_c + sum_e dL/dextra_e * extra_e +
  // dL/dT * T of the finished pixel, background included.
  float remaining[kTilePixels];
};

// Walks the list as BlendTile did (the first `visited` entries) and writes the
// sums of list entry k to moments + k * (kMomentStride + num_extras).
// extra_gradients is dL/dextra, [channel * 256 + TilePixel].
// Clobbers
// gradients->remaining.
void BackwardTile(const TileTask& task,
                  int64_t visited,
                  TileGradients* gradients,
                  const float* extra_gradients,
                  float* moments);

// The instruction set the kernels run with, such as "AVX3" or "NEON".
const char* TileKernelTarget();

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_TILE_KERNELS_H_
