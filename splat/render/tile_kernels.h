// SPDX-License-Identifier: BSD-3-Clause
// The inner loops of the rasteriser: alpha blending of the depth-ordered splats
// of one tile, and its derivative, with one pixel per SIMD lane. Highway
// compiles them for several instruction sets and chooses one at run time.
//
// Blending (Kerbl et al. 2023, eq. 3): alpha_i = min(0.99, o_i exp(-q_i / 2)),
// q_i = d^T conic d, weight w_i = alpha_i T_i, T_{i+1} = T_i (1 - alpha_i).
// Splats with alpha < 1/255, and pixels whose T fell under 1e-4, are skipped.

#ifndef FREEGS_SPLAT_RENDER_TILE_KERNELS_H_
#define FREEGS_SPLAT_RENDER_TILE_KERNELS_H_

#include <cstdint>
#include <span>

#include "splat/render/tile_layout.h"

namespace freegs::splat {

// Blends the list front to back into *pixels and, when task.num_extras > 0,
// into extras[channel * 256 + TilePixel] (64-byte aligned). Overwrites both,
// and *dominance unless it is null. Stops when the tile is opaque, and returns
// how many list entries it has visited. Of each of them it writes the blocks
// into which it may have been blended to touched[k]; there must be room for
// task.count.
int64_t BlendTile(const TileTask& task,
                  TilePixels* pixels,
                  float* extras,
                  TileDominance* dominance,
                  TileBlocks* touched);

// Computes the blending weights without blending colours. Overwrites
// transmittance (256 floats, 64-byte aligned) and *dominance, and writes what
// list entry k contributed to contributions[k].
void ContributeTile(const TileTask& task,
                    float* transmittance,
                    TileDominance* dominance,
                    PairContribution* contributions);

// Adds the weight of list entry k at each pixel to
// votes[channels[k] * 256 + TilePixel]. Entries whose channel is negative are
// blended, but add no vote.
void VoteTile(const TileTask& task, const int32_t* channels, float* votes);

// The derivative of BlendTile, which wrote `touched`: one value for each entry
// that it visited. Writes the sums of list entry k (see kMomentStride in
// splat.h) to moments + k * (kMomentStride + num_extras). extra_gradients is
// dL/dextra at [channel * 256 + TilePixel]. gradients->remaining is used as
// scratch memory and holds other values afterwards.
void BackwardTile(const TileTask& task,
                  std::span<const TileBlocks> touched,
                  TileGradients* gradients,
                  const float* extra_gradients,
                  float* moments);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_RENDER_TILE_KERNELS_H_
