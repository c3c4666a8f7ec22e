// SPDX-License-Identifier: BSD-3-Clause

#include "splat/weights/blending_weights.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "splat/projection/projection.h"
#include "splat/render/tile_bins.h"
#include "splat/render/tile_task.h"
#include "splat/weights/tile_weights_simd.h"

namespace freegs::splat {
namespace {

// The weights of one tile, pixel after pixel in row-major order.
struct TileWeights {
  RawVector<uint32_t> gaussians;
  RawVector<float> weights;
};

// What one thread needs to bring the weights of a tile into the order of
// pixels: the batches, one after the other, and their pixels by TilePixel.
struct TileScratch {
  TileWeightList batch;
  alignas(64) float transmittance[kTilePixels];
  RawVector<uint8_t> pixels;
  TileWeights unsorted;
  std::array<uint32_t, kTilePixels> counts;
  std::array<uint32_t, kTilePixels> next;
};
static_assert(kTilePixels <= 256, "a pixel of a tile is one byte");

// Blends all splats of a tile and keeps their weights in the order of splats.
void BlendAll(const TileTask& task, TileScratch* scratch) {
  scratch->counts.fill(0);
  scratch->pixels.clear();
  scratch->unsorted.gaussians.clear();
  scratch->unsorted.weights.clear();
  const TileWeightList& batch = scratch->batch;
  for (int64_t begin = 0; begin < task.count;) {
    const int64_t next =
        ListTileWeights(task, begin, scratch->transmittance, &scratch->batch);
    const size_t old_size = scratch->pixels.size();
    scratch->pixels.resize(old_size + batch.count);
    scratch->unsorted.gaussians.resize(old_size + batch.count);
    for (int32_t j = 0; j < batch.count; ++j) {
      const uint32_t pixel = TileWeightList::PixelOf(batch.place[j]);
      ++scratch->counts[pixel];
      scratch->pixels[old_size + j] = static_cast<uint8_t>(pixel);
      scratch->unsorted.gaussians[old_size + j] =
          task.entries[begin + TileWeightList::EntryOf(batch.place[j])];
    }
    scratch->unsorted.weights.insert(scratch->unsorted.weights.end(),
                                     batch.weight,
                                     batch.weight + batch.count);
    begin = next;
  }
}

// Calls visit(row of W, pixel by TilePixel) for the pixels of a tile inside the
// image.
template <typename Visit>
void ForEachPixel(const TileTask& task, int width, const Visit& visit) {
  for (int y = 0; y < task.height; ++y) {
    const size_t row = static_cast<size_t>(task.y0 + y) * width + task.x0;
    for (int x = 0; x < task.width; ++x) visit(row + x, TilePixel(x, y));
  }
}

// The weights of a tile that BlendAll has blended. The weights of one pixel
// stay in the order of splats.
TileWeights SortByPixel(const TileTask& task, TileScratch* scratch) {
  uint32_t count = 0;
  ForEachPixel(task, 0, [&](size_t, int pixel) {
    scratch->next[pixel] = count;
    count += scratch->counts[pixel];
  });
  TileWeights sorted;
  sorted.gaussians.resize(count);
  sorted.weights.resize(count);
  for (size_t j = 0; j < scratch->pixels.size(); ++j) {
    const uint32_t k = scratch->next[scratch->pixels[j]]++;
    sorted.gaussians[k] = scratch->unsorted.gaussians[j];
    sorted.weights[k] = scratch->unsorted.weights[j];
  }
  return sorted;
}

}  // namespace

Status ComputeBlendingWeights(const GaussianModel& model,
                              const Pinhole& camera,
                              const Rigid3d& cam_from_world,
                              const RenderOptions& options,
                              ThreadPool& pool,
                              BlendingWeights* result) {
  if (camera.width <= 0 || camera.height <= 0) {
    return InvalidArgumentError("a camera of " + std::to_string(camera.width) +
                                " x " + std::to_string(camera.height) +
                                " pixels has no blending weights");
  }
  result->width = camera.width;
  result->height = camera.height;
  result->num_gaussians = model.size();
  const size_t num_pixels = static_cast<size_t>(camera.width) * camera.height;
  RenderOptions without_color = options;
  without_color.sh_degree = 0;
  Projector projector;
  Projection projection;
  projector.Project(
      model, camera, cam_from_world, without_color, pool, &projection);
  TileBins bins;
  FREEGS_RETURN_IF_ERROR(
      BinSplats(projection, camera.width, camera.height, pool, &bins));
  const int64_t num_tiles = static_cast<int64_t>(bins.tiles_x) * bins.tiles_y;
  const auto task_of = [&](int64_t tile) {
    return MakeTileTask(projection, bins, camera.width, camera.height, tile);
  };

  result->pixel_begin.resize(num_pixels + 1);
  result->pixel_begin[0] = 0;
  std::vector<TileWeights> tiles(num_tiles);
  std::vector<TileScratch> scratches(pool.num_threads());
  pool.ParallelFor(
      0, num_tiles, 1, [&](int64_t first, int64_t last, int worker) {
        TileScratch& scratch = scratches[worker];
        for (int64_t tile = first; tile < last; ++tile) {
          const TileTask task = task_of(tile);
          BlendAll(task, &scratch);
          tiles[tile] = SortByPixel(task, &scratch);
          ForEachPixel(task, camera.width, [&](size_t row, int pixel) {
            result->pixel_begin[row + 1] = scratch.counts[pixel];
          });
        }
      });
  uint64_t total = 0;
  for (uint32_t& end : result->pixel_begin) {
    total += end;
    end = static_cast<uint32_t>(total);
  }
  if (total > std::numeric_limits<uint32_t>::max()) {
    return UnusableResultError(
        "a view of " + std::to_string(camera.width) + " x " +
        std::to_string(camera.height) + " pixels has " + std::to_string(total) +
        " blending weights, more than 32 bits can count; use smaller images");
  }

  result->gaussians.resize(total);
  result->weights.resize(total);
  pool.ParallelFor(0, num_tiles, 1, [&](int64_t first, int64_t last, int) {
    for (int64_t tile = first; tile < last; ++tile) {
      const TileTask task = task_of(tile);
      const TileWeights from = std::move(tiles[tile]);
      size_t done = 0;
      for (int y = 0; y < task.height; ++y) {
        const size_t row =
            static_cast<size_t>(task.y0 + y) * camera.width + task.x0;
        const size_t begin = result->pixel_begin[row];
        const size_t count = result->pixel_begin[row + task.width] - begin;
        std::copy_n(from.gaussians.data() + done,
                    count,
                    result->gaussians.data() + begin);
        std::copy_n(
            from.weights.data() + done, count, result->weights.data() + begin);
        done += count;
      }
    }
  });
  return Status();
}

StatusOr<BlendingWeights> ComputeBlendingWeights(const GaussianModel& model,
                                                 const Pinhole& camera,
                                                 const Rigid3d& cam_from_world,
                                                 const RenderOptions& options,
                                                 ThreadPool& pool) {
  BlendingWeights result;
  FREEGS_RETURN_IF_ERROR(ComputeBlendingWeights(
      model, camera, cam_from_world, options, pool, &result));
  return result;
}

}  // namespace freegs::splat
