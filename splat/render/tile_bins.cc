// SPDX-License-Identifier: BSD-3-Clause

#include "splat/render/tile_bins.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace freegs::splat {
namespace {

// The ellipse d^T conic d <= reach around a splat's mean.
class Ellipse {
 public:
  explicit Ellipse(const Splat& splat) : splat_(splat) {
    // extent_x^2 = reach * cov_xx = reach * conic_yy / det; the rightmost point
    // lies at dy = -conic_xy / conic_yy * extent_x.
    right_dy_ = -splat.conic_xy / splat.conic_yy * splat.extent_x;
    const float determinant =
        splat.conic_xx * splat.conic_yy - splat.conic_xy * splat.conic_xy;
    reach_ = splat.extent_x * splat.extent_x * determinant / splat.conic_yy;
  }

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
    const float b = splat_.conic_xy * dy;
    const float discriminant =
        b * b - splat_.conic_xx * (splat_.conic_yy * dy * dy - reach_);
    return (-b + sign * std::sqrt(std::max(discriminant, 0.0f))) /
           splat_.conic_xx;
  }

  const Splat& splat_;
  float right_dy_;
  float reach_;
};

// Added to the chord, in pixels, to make up for rounding: one tile too many
// costs little, but a missing tile shows as a seam.
constexpr float kSlack = 0.01f;

int TileOf(float pixel_centre, int tiles) {
  const float tile = std::floor(pixel_centre / kTileSize);
  return static_cast<int>(std::clamp(tile, -1.0f, static_cast<float>(tiles)));
}

// Calls visit(first_tile, last_tile) for each tile row the splat touches.
template <typename Visit>
void ForEachTileRun(const Splat& splat,
                    int tiles_x,
                    int tiles_y,
                    const Visit& visit) {
  // Pixel centres lie at k + 0.5: tile ty holds centres 16 ty + 0.5 ... + 15.5.
  const int row_begin = std::max(
      0, TileOf(splat.mean_y - splat.extent_y - kSlack + 0.5f, tiles_y));
  const int row_end =
      std::min(tiles_y - 1,
               TileOf(splat.mean_y + splat.extent_y + kSlack - 0.5f, tiles_y));
  const int column_begin = std::max(
      0, TileOf(splat.mean_x - splat.extent_x - kSlack + 0.5f, tiles_x));
  const int column_end =
      std::min(tiles_x - 1,
               TileOf(splat.mean_x + splat.extent_x + kSlack - 0.5f, tiles_x));
  if (column_begin > column_end) return;
  if (row_begin >= row_end || column_begin == column_end) {
    // In a single row or column of tiles the box touches the same tiles as the
    // ellipse.
    for (int ty = row_begin; ty <= row_end; ++ty) {
      visit(ty * tiles_x + column_begin, ty * tiles_x + column_end);
    }
    return;
  }
  const Ellipse ellipse(splat);
  for (int ty = row_begin; ty <= row_end; ++ty) {
    const float y0 = static_cast<float>(ty * kTileSize) + 0.5f - kSlack;
    const float y1 = y0 + (kTileSize - 1) + 2 * kSlack;
    float x_min = 0, x_max = 0;
    if (!ellipse.Cut(y0, y1, &x_min, &x_max)) continue;
    const int first =
        std::max(column_begin, TileOf(x_min - kSlack + 0.5f, tiles_x));
    const int last =
        std::min(column_end, TileOf(x_max + kSlack - 0.5f, tiles_x));
    if (first <= last) visit(ty * tiles_x + first, ty * tiles_x + last);
  }
}

}  // namespace

void BinSplats(std::span<const Splat> splats,
               int width,
               int height,
               ThreadPool& pool,
               TileBins* bins) {
  bins->tiles_x = (width + kTileSize - 1) / kTileSize;
  bins->tiles_y = (height + kTileSize - 1) / kTileSize;
  const auto tiles = static_cast<size_t>(bins->tiles_x) * bins->tiles_y;
  const auto count = static_cast<int64_t>(splats.size());

  // Each chunk of splats lists its runs of tiles and counts its pairs per tile;
  // prefix sums over chunks then give every chunk its own place in every tile's
  // list, so that filling needs no lock and the order is the same for any
  // number of chunks.
  const int64_t num_chunks = std::max(1, 2 * pool.num_threads());
  const int64_t chunk_size = (count + num_chunks - 1) / num_chunks;
  std::vector<TileBins::Chunk>& chunks = bins->chunks;
  chunks.resize(num_chunks);
  bins->splat_begin.resize(splats.size() + 1);
  bins->splat_begin[0] = 0;
  const auto chunk_range = [&](int64_t chunk) {
    return std::pair(std::min(count, chunk * chunk_size),
                     std::min(count, (chunk + 1) * chunk_size));
  };
  pool.ParallelFor(0, num_chunks, 1, [&](int64_t index, int64_t, int) {
    TileBins::Chunk& chunk = chunks[index];
    chunk.runs.clear();
    chunk.places.assign(tiles, 0);
    const auto [begin, end] = chunk_range(index);
    for (int64_t s = begin; s < end; ++s) {
      uint32_t pairs = 0;
      ForEachTileRun(
          splats[s], bins->tiles_x, bins->tiles_y, [&](int first, int last) {
            for (int t = first; t <= last; ++t) ++chunk.places[t];
            pairs += static_cast<uint32_t>(last - first + 1);
            chunk.runs.push_back({static_cast<uint32_t>(s), first, last});
          });
      bins->splat_begin[s + 1] = pairs;
    }
  });
  for (size_t s = 0; s < splats.size(); ++s) {
    bins->splat_begin[s + 1] += bins->splat_begin[s];
  }
  bins->tile_begin.resize(tiles + 1);
  int64_t total = 0;
  for (size_t t = 0; t < tiles; ++t) {
    bins->tile_begin[t] = total;
    for (TileBins::Chunk& chunk : chunks) {
      total += std::exchange(chunk.places[t], static_cast<uint32_t>(total));
    }
  }
  bins->tile_begin[tiles] = total;
  bins->entries.resize(total);
  bins->entries_of_splats.resize(total);
  pool.ParallelFor(0, num_chunks, 1, [&](int64_t index, int64_t, int) {
    TileBins::Chunk& chunk = chunks[index];
    uint32_t pair = bins->splat_begin[chunk_range(index).first];
    for (const TileBins::Run& run : chunk.runs) {
      for (int t = run.first; t <= run.last; ++t) {
        const uint32_t place = chunk.places[t]++;
        bins->entries[place] = run.splat;
        bins->entries_of_splats[pair++] = place;
      }
    }
  });
}

}  // namespace freegs::splat
