// SPDX-License-Identifier: BSD-3-Clause
// Lists, for each tile of the image, the splats that touch it in depth order.

#ifndef FREEGS_SPLAT_RENDER_TILE_BINS_H_
#define FREEGS_SPLAT_RENDER_TILE_BINS_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"
#include "splat/projection/projection.h"
#include "splat/render/tile_layout.h"

namespace freegs::splat {

// Tile (tx, ty) is tile number ty * tiles_x + tx and covers pixels
// [16 tx, 16 tx + 16) x [16 ty, 16 ty + 16).
struct TileBins {
  int tiles_x = 0;
  int tiles_y = 0;
  // The entries of tile t are [tile_begin[t], tile_begin[t + 1]).
  std::vector<int64_t> tile_begin;
  // The Gaussians of each tile's splats, from near to far.
  std::vector<uint32_t> entries;
  // The entries of the Gaussian at a place in Projection::visible, by tile, are
  // entries_of_places[k] for k in [place_begin[place], place_begin[place + 1]);
  // each is an index into `entries`.
  std::vector<uint32_t> entries_of_places;
  std::vector<uint32_t> place_begin;

  // Scratch memory of BinSplats, kept so that the next view allocates none.
  struct Run {
    int32_t first, last;  // Tiles of one row, both included.
  };
  // What is needed to list a splat, in one piece because splats are listed by
  // depth and so read in no order at all. `run` is the splat's only run; or,
  // when run.last is negative, run.first is the first of its -1 - run.last runs
  // in its chunk's list.
  struct Footprint {
    uint32_t gaussian;
    uint32_t first_entry;  // Into entries_of_places.
    Run run;
  };
  struct Chunk {
    std::vector<Run> runs;
    std::vector<uint32_t> counts;  // By tile, then where its next entry goes.
  };
  std::vector<Footprint> footprints;  // By place.
  std::vector<Chunk> chunks;

  std::span<const uint32_t> EntriesOf(size_t place) const {
    return std::span(entries_of_places)
        .subspan(place_begin[place],
                 place_begin[place + 1] - place_begin[place]);
  }
  size_t num_pairs() const { return entries.size(); }
};

// Fills *bins for an image of width x height. A splat is listed in the tiles
// that have a pixel centre inside its ellipse alpha >= 1/255, and in no others
// but for rounding: each row of tiles is intersected with the ellipse. Fails
// with kUnusableResult when there are 2^31 pairs of splats and tiles or more.
Status BinSplats(const Projection& projection,
                 int width,
                 int height,
                 ThreadPool& pool,
                 TileBins* bins);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_RENDER_TILE_BINS_H_
