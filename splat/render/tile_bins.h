// SPDX-License-Identifier: BSD-3-Clause
// Which splats touch which tile, in depth order.

#ifndef FREEGS_SPLAT_RENDER_TILE_BINS_H_
#define FREEGS_SPLAT_RENDER_TILE_BINS_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "splat/render/tile_layout.h"

namespace freegs::splat {

// Tile (tx, ty) is tile number ty * tiles_x + tx and covers pixels
// [16 tx, 16 tx + 16) x [16 ty, 16 ty + 16).
struct TileBins {
  int tiles_x = 0;
  int tiles_y = 0;
  // Entries of tile t: [tile_begin[t], tile_begin[t + 1]).
  std::vector<int64_t> tile_begin;
  std::vector<uint32_t> entries;  // Splat numbers, ascending within a tile.
  // The same pairs splat after splat: those of splat s are the entries
  // entries_of_splats[splat_begin[s]] ... [splat_begin[s + 1] - 1], by tile.
  std::vector<uint32_t> entries_of_splats;
  std::vector<uint32_t> splat_begin;

  // Memory of BinSplats, kept so that the next view need not ask for it.
  struct Run {
    uint32_t splat;
    int32_t first, last;  // Tiles, in one row.
  };
  struct Chunk {
    std::vector<Run> runs;
    std::vector<uint32_t> places;  // Per tile, where its next pair goes.
  };
  std::vector<Chunk> chunks;

  std::span<const uint32_t> EntriesOf(size_t splat) const {
    return std::span(entries_of_splats)
        .subspan(splat_begin[splat],
                 splat_begin[splat + 1] - splat_begin[splat]);
  }
  size_t num_pairs() const { return entries.size(); }
};

// Fills *bins for an image of width x height. A splat enters exactly the tiles
// that have a pixel centre inside its ellipse alpha >= 1/255 or come within
// rounding of it: each tile row is cut with the ellipse.
void BinSplats(std::span<const Splat> splats,
               int width,
               int height,
               ThreadPool& pool,
               TileBins* bins);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_RENDER_TILE_BINS_H_
