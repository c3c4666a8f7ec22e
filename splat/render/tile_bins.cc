// SPDX-License-Identifier: BSD-3-Clause

#include "splat/render/tile_bins.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include <hwy/cache_control.h>

namespace freegs::splat {
namespace {

constexpr auto kLn2 = std::numbers::ln2_v<float>;

// The ellipse around a splat's mean in which its alpha is 1/255 or more.
class Ellipse {
 public:
  explicit Ellipse(const Splat& splat)
      : splat_(splat),
        half_width_(std::sqrt(2 * kLn2 * (splat.log2_opacity - kMinLog2Alpha) /
                              splat.conic_xx)),
        right_dy_(-splat.shear * splat.extent_y *
                  (splat.extent_y / splat.extent_x)) {}

  // The x range of the ellipse (absolute pixels) over y in [y0, y1]; false when
  // the band misses it.
  bool Cut(float y0, float y1, float* x_min, float* x_max) const {
    const float lo = std::max(y0 - splat_.mean_y, -splat_.extent_y);
    const float hi = std::min(y1 - splat_.mean_y, splat_.extent_y);
    if (!(lo <= hi)) return false;
    *x_max = splat_.mean_x + Side(std::clamp(right_dy_, lo, hi), 1.0f);
    *x_min = splat_.mean_x + Side(std::clamp(-right_dy_, lo, hi), -1.0f);
    return true;
  }

 private:
  // The right (sign 1) or left (-1) end of the chord at dy.
  float Side(float dy, float sign) const {
    const float t = dy / splat_.extent_y;
    const float half_chord =
        half_width_ * std::sqrt(std::max((1 - t) * (1 + t), 0.0f));
    return sign * half_chord - splat_.shear * dy;
  }

  const Splat& splat_;
  float half_width_;  // Half of the chord through the mean.
  float right_dy_;    // Where the ellipse is farthest to the right.
};

// Added to the chord, in pixels, to make up for rounding, which is less while
// the mean lies within some ten thousand pixels of the tile: one tile too many
// costs little, but a missing tile shows as a seam.
constexpr float kSlack = 0.01f;

int TileOf(float pixel_centre, int tiles) {
  const float tile = std::floor(pixel_centre / kTileSize);
  return static_cast<int>(std::clamp(tile, -1.0f, static_cast<float>(tiles)));
}

// Calls visit(run) for each tile row the splat touches.
template <typename Visit>
void ForEachTileRun(const Splat& splat, int tiles_x, const Visit& visit) {
  // Nothing is blended outside the splat's box.
  const int row_begin = splat.y_begin / kTileSize;
  const int row_end = (splat.y_end - 1) / kTileSize;
  const int column_begin = splat.x_begin / kTileSize;
  const int column_end = (splat.x_end - 1) / kTileSize;
  if (splat.x_begin >= splat.x_end || splat.y_begin >= splat.y_end) return;
  if (row_begin == row_end || column_begin == column_end) {
    // In a single row or column of tiles the box touches the same tiles as the
    // ellipse.
    for (int ty = row_begin; ty <= row_end; ++ty) {
      visit({ty * tiles_x + column_begin, ty * tiles_x + column_end});
    }
    return;
  }
  const Ellipse ellipse(splat);
  for (int ty = row_begin; ty <= row_end; ++ty) {
    // Pixel centres lie at k + 0.5: tile ty holds 16 ty + 0.5 ... + 15.5.
    const float y0 = static_cast<float>(ty * kTileSize) + 0.5f - kSlack;
    const float y1 = y0 + (kTileSize - 1) + 2 * kSlack;
    float x_min = 0, x_max = 0;
    if (!ellipse.Cut(y0, y1, &x_min, &x_max)) continue;
    const int first =
        std::max(column_begin, TileOf(x_min - kSlack + 0.5f, tiles_x));
    const int last =
        std::min(column_end, TileOf(x_max + kSlack - 0.5f, tiles_x));
    if (first <= last) visit({ty * tiles_x + first, ty * tiles_x + last});
  }
}

// A footprint is requested from memory so many splats before it is read.
constexpr int64_t kAhead = 16;

// Finds the tiles of each splat, in the order of the model, and returns the
// number of all pairs. The 32-bit counts in
// *bins are wrong if there are 2^32 of them or more.
uint64_t FindFootprints(const Projection& projection,
                        int64_t chunk_size,
                        ThreadPool& pool,
                        TileBins* bins) {
  const auto count = static_cast<int64_t>(projection.size());
  bins->place_begin.resize(projection.size() + 1);
  bins->place_begin[0] = 0;
  bins->footprints.resize(projection.size());
  pool.ParallelFor(0, count, chunk_size, [&](int64_t begin, int64_t end, int) {
    std::vector<TileBins::Run>& runs = bins->chunks[begin / chunk_size].runs;
    for (int64_t place = begin; place < end; ++place) {
      const uint32_t i = projection.visible[place];
      const auto first_run = static_cast<int32_t>(runs.size());
      uint32_t entries = 0;
      ForEachTileRun(
          projection.splats[i], bins->tiles_x, [&](TileBins::Run run) {
            entries += static_cast<uint32_t>(run.last - run.first + 1);
            runs.push_back(run);
          });
      bins->place_begin[place + 1] = entries;
      TileBins::Footprint& footprint = bins->footprints[place];
      footprint.gaussian = i;
      const auto num_runs = static_cast<int32_t>(runs.size()) - first_run;
      footprint.run = {first_run, -1 - num_runs};
      if (num_runs == 1) {
        footprint.run = runs.back();
        runs.pop_back();
      }
    }
  });
  uint64_t total = 0;
  for (int64_t place = 0; place < count; ++place) {
    bins->footprints[place].first_entry = static_cast<uint32_t>(total);
    total += bins->place_begin[place + 1];
    bins->place_begin[place + 1] = static_cast<uint32_t>(total);
  }
  return total;
}

}  // namespace

Status BinSplats(const Projection& projection,
                 int width,
                 int height,
                 ThreadPool& pool,
                 TileBins* bins) {
  bins->tiles_x = (width + kTileSize - 1) / kTileSize;
  bins->tiles_y = (height + kTileSize - 1) / kTileSize;
  const auto tiles = static_cast<size_t>(bins->tiles_x) * bins->tiles_y;
  const auto count = static_cast<int64_t>(projection.size());
  const int64_t num_chunks = pool.num_threads();
  const int64_t chunk_size =
      std::max<int64_t>(1, (count + num_chunks - 1) / num_chunks);
  bins->chunks.resize(num_chunks);
  for (TileBins::Chunk& chunk : bins->chunks) chunk.runs.clear();

  const uint64_t pairs = FindFootprints(projection, chunk_size, pool, bins);
  if (pairs > std::numeric_limits<int32_t>::max()) {
    return UnusableResultError(
        "a view of " + std::to_string(width) + " x " + std::to_string(height) +
        " pixels has " + std::to_string(pairs) +
        " pairs of splats and tiles, more than can be counted; use smaller "
        "images");
  }
  for (TileBins::Chunk& chunk : bins->chunks) chunk.counts.assign(tiles, 0);

  // Each tile's splats, by depth. Each chunk of splats counts its entries
  // of each tile; sums over the chunks then give every chunk its own place in
  // every tile's list, so that filling needs no lock and the order is the same
  // for any number of chunks.
  const auto for_each_run = [&](int64_t place, const auto& visit) {
    const TileBins::Footprint& footprint = bins->footprints[place];
    if (footprint.run.last >= 0) {
      visit(footprint.run);
      return;
    }
    const std::vector<TileBins::Run>& runs =
        bins->chunks[place / chunk_size].runs;
    for (int32_t r = 0; r < -1 - footprint.run.last; ++r) {
      visit(runs[footprint.run.first + r]);
    }
  };
  const auto for_each_by_depth =
      [&](int64_t begin, int64_t end, const auto& visit) {
        for (int64_t k = begin; k < end; ++k) {
          const int64_t ahead = std::min(k + kAhead, end - 1);
          hwy::Prefetch(&bins->footprints[projection.by_depth[ahead]]);
          visit(projection.by_depth[k]);
        }
      };
  pool.ParallelFor(0, count, chunk_size, [&](int64_t begin, int64_t end, int) {
    std::vector<uint32_t>& counts = bins->chunks[begin / chunk_size].counts;
    for_each_by_depth(begin, end, [&](uint32_t place) {
      for_each_run(place, [&](TileBins::Run run) {
        for (int t = run.first; t <= run.last; ++t) ++counts[t];
      });
    });
  });
  bins->tile_begin.resize(tiles + 1);
  int64_t total = 0;
  for (size_t t = 0; t < tiles; ++t) {
    bins->tile_begin[t] = total;
    for (TileBins::Chunk& chunk : bins->chunks) {
      total += std::exchange(chunk.counts[t], static_cast<uint32_t>(total));
    }
  }
  bins->tile_begin[tiles] = total;
  bins->entries.resize(total);
  bins->entries_of_places.resize(total);
  pool.ParallelFor(0, count, chunk_size, [&](int64_t begin, int64_t end, int) {
    std::vector<uint32_t>& next = bins->chunks[begin / chunk_size].counts;
    for_each_by_depth(begin, end, [&](uint32_t place) {
      const TileBins::Footprint& footprint = bins->footprints[place];
      uint32_t entry_of_place = footprint.first_entry;
      for_each_run(place, [&](TileBins::Run run) {
        for (int t = run.first; t <= run.last; ++t) {
          const uint32_t entry = next[t]++;
          bins->entries[entry] = footprint.gaussian;
          bins->entries_of_places[entry_of_place++] = entry;
        }
      });
    });
  });
  return Status();
}

}  // namespace freegs::splat
