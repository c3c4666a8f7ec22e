// SPDX-License-Identifier: BSD-3-Clause
// Lists, for each tile of the image, the splats that touch it in depth order.

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
  // The entries of tile t are [tile_begin[t], tile_begin[t + 1]).
  std::vector<int64_t> tile_begin;
  // Splat numbers, ascending within a tile, which is from near to far.
  std::vector<uint32_t> entries;
  // The entries of splat s, by tile, are entries_of_splats[k] for k in
  // [splat_begin[s], splat_begin[s + 1]); each is an index into `entries`.
  std::vector<uint32_t> entries_of_splats;
  std::vector<uint32_t> splat_begin;

  // Scratch memory of BinSplats, kept so that the next view allocates none.
  struct Run {
    uint32_t splat;
    int32_t first, last;  // Tiles of one row, both included.
  };
  struct Chunk {
    std::vector<Run> runs;
    std::vector<uint32_t> places;  // By tile, where its next entry goes.
  };
  std::vector<Chunk> chunks;

  std::span<const uint32_t> EntriesOf(size_t splat) const {
    return std::span(entries_of_splats)
        .subspan(splat_begin[splat],
                 splat_begin[splat + 1] - splat_begin[splat]);
  }
  size_t num_pairs() const { return entries.size(); }
};

// Fills *bins for an image of width x height. A splat is listed in the tiles
// that have a pixel centre inside its ellipse alpha >= 1/255, and in no others
// but for rounding: each row of tiles is intersected with the ellipse.
void BinSplats(std::span<const Splat> splats,
               int width,
               int height,
               ThreadPool& pool,
               TileBins* bins);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_RENDER_TILE_BINS_H_
