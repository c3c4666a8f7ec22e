// SPDX-License-Identifier: BSD-3-Clause
// The work of one tile of a projected and binned view.

#ifndef FREEGS_SPLAT_RENDER_TILE_TASK_H_
#define FREEGS_SPLAT_RENDER_TILE_TASK_H_

#include <algorithm>
#include <cstdint>

#include "splat/projection/projection.h"
#include "splat/render/tile_bins.h"
#include "splat/render/tile_layout.h"

namespace freegs::splat {

// Makes the task of tile number `tile`. `bins` must hold the splats of
// `projection` for an image of width x height. The task points into both and
// has no extra values.
inline TileTask MakeTileTask(const Projection& projection,
                             const TileBins& bins,
                             int width,
                             int height,
                             int64_t tile) {
  TileTask task;
  task.splats = projection.splats.data();
  task.entries = bins.entries.data() + bins.tile_begin[tile];
  task.count = bins.tile_begin[tile + 1] - bins.tile_begin[tile];
  task.x0 = static_cast<int>(tile % bins.tiles_x) * kTileSize;
  task.y0 = static_cast<int>(tile / bins.tiles_x) * kTileSize;
  task.width = std::min(kTileSize, width - task.x0);
  task.height = std::min(kTileSize, height - task.y0);
  return task;
}

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_RENDER_TILE_TASK_H_
