// SPDX-License-Identifier: BSD-3-Clause
// The inner loops of the rasteriser: alpha blending of depth-ordered splats in
// one tile, forward and backward, SIMD over pixels. Compiled for several
// instruction sets by Highway and chosen at run time.
//
// Blending (Kerbl et al. 2023, eq. 3): alpha_i = min(0.99, o_i exp(-q_i / 2)),
// q_i = d^T conic d, weight w_i = alpha_i T_i, T_{i+1} = T_i (1 - alpha_i).
// Splats with alpha < 1/255, and pixels whose T fell under 1e-4, are skipped.

#ifndef FREEGS_SPLAT_RENDER_TILE_KERNELS_H_
#define FREEGS_SPLAT_RENDER_TILE_KERNELS_H_

#include <cstdint>

#include "splat/render/tile_layout.h"

namespace freegs::splat {

// Blends the list front to back into *pixels and, when task.num_extras > 0,
// into extras[channel * 256 + TilePixel] (64-byte aligned), both overwritten.
// Also fills *dominance unless it is null. Returns how many list entries had
// been visited when the tile was opaque.
int64_t BlendTile(const TileTask& task,
                  TilePixels* pixels,
                  float* extras,
                  TileDominance* dominance = nullptr);

// Blends weights only: overwrites transmittance (256 floats, 64-byte aligned)
// and *dominance, and writes what list entry k gave to contributions[k].
void ContributeTile(const TileTask& task,
                    float* transmittance,
                    TileDominance* dominance,
                    PairContribution* contributions);

// Adds to votes[channel * 256 + TilePixel] the weight of every splat, where
// channel is channels[k] of list entry k (negative: none).
void VoteTile(const TileTask& task, const int32_t* channels, float* votes);

// Walks the list as BlendTile did (the first `visited` entries) and writes the
// sums of list entry k to moments + k * (kMomentStride + num_extras).
// extra_gradients is dL/dextra, [channel * 256 + TilePixel].
// Clobbers gradients->remaining.
void BackwardTile(const TileTask& task,
                  int64_t visited,
                  TileGradients* gradients,
                  const float* extra_gradients,
                  float* moments);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_RENDER_TILE_KERNELS_H_
