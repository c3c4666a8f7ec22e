// SPDX-License-Identifier: BSD-3-Clause

#include "splat/weights/blending_weights.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include "splat/projection/projection.h"
#include "splat/render/tile_bins.h"
#include "splat/render/tile_task.h"
#include "splat/weights/tile_weights_simd.h"

namespace freegs::splat {
namespace {

// One number per pixel of a tile, by TilePixel.
using TileNumbers = std::array<uint32_t, kTilePixels>;

// A view that is projected and binned. It can be blended tile by tile any
// number of times, each time with the same weights.
class WeightLister {
 public:
  WeightLister(const GaussianModel& model,
               const Pinhole& camera,
               const Rigid3d& cam_from_world,
               RenderOptions options,
               ThreadPool& pool)
      : width_(camera.width),
        height_(camera.height),
        pool_(pool),
        lists_(pool.num_threads()) {
    options.sh_degree = 0;  // Colour is not looked at.
    Projector projector;
    projector.Project(
        model, camera, cam_from_world, options, pool, &projection_);
    BinSplats(projection_, width_, height_, pool, &bins_);
  }

  // Blends all tiles on several threads. For each tile it calls
  // begin_tile(task, &numbers), where all numbers are zero; then add(list,
  // gaussian_of, &numbers) for each batch of weights, where gaussian_of(place)
  // is the Gaussian of a place in the list; then end_tile(task, numbers).
  template <typename BeginTile, typename Add, typename EndTile>
  void ForEachTile(const BeginTile& begin_tile,
                   const Add& add,
                   const EndTile& end_tile) {
    const int64_t tiles = static_cast<int64_t>(bins_.tiles_x) * bins_.tiles_y;
    pool_.ParallelFor(
        0, tiles, 1, [&](int64_t first, int64_t last, int worker) {
          TileWeightList& list = lists_[worker];
          alignas(64) float transmittance[kTilePixels];
          for (int64_t tile = first; tile < last; ++tile) {
            const TileTask task =
                MakeTileTask(projection_, bins_, width_, height_, tile);
            TileNumbers numbers = {};
            begin_tile(task, &numbers);
            for (int64_t begin = 0; begin < task.count;) {
              const int64_t next =
                  ListTileWeights(task, begin, transmittance, &list);
              const uint32_t* entries = task.entries + begin;
              const auto gaussian_of = [&](uint32_t place) {
                return entries[TileWeightList::EntryOf(place)];
              };
              add(list, gaussian_of, &numbers);
              begin = next;
            }
            end_tile(task, numbers);
          }
        });
  }

 private:
  const int width_;
  const int height_;
  ThreadPool& pool_;
  Projection projection_;
  TileBins bins_;
  std::vector<TileWeightList> lists_;  // One per thread.
};

// Calls visit(row, tile_pixel) for the pixels of a tile inside the image.
template <typename Visit>
void ForEachPixel(const TileTask& task, int width, const Visit& visit) {
  for (int y = 0; y < task.height; ++y) {
    const size_t row = static_cast<size_t>(task.y0 + y) * width + task.x0;
    for (int x = 0; x < task.width; ++x) visit(row + x, TilePixel(x, y));
  }
}

}  // namespace

StatusOr<BlendingWeights> ComputeBlendingWeights(const GaussianModel& model,
                                                 const Pinhole& camera,
                                                 const Rigid3d& cam_from_world,
                                                 const RenderOptions& options,
                                                 ThreadPool& pool) {
  if (camera.width <= 0 || camera.height <= 0) {
    return InvalidArgumentError("a camera of " + std::to_string(camera.width) +
                                " x " + std::to_string(camera.height) +
                                " pixels has no blending weights");
  }
  BlendingWeights result;
  result.width = camera.width;
  result.height = camera.height;
  result.num_gaussians = model.size();
  const size_t num_pixels = static_cast<size_t>(camera.width) * camera.height;
  WeightLister lister(model, camera, cam_from_world, options, pool);

  result.pixel_begin.resize(num_pixels + 1);
  lister.ForEachTile(
      [](const TileTask&, TileNumbers*) {},
      [](const TileWeightList& list, const auto&, TileNumbers* counts) {
        for (int32_t j = 0; j < list.count; ++j) {
          ++(*counts)[TileWeightList::PixelOf(list.place[j])];
        }
      },
      [&](const TileTask& task, const TileNumbers& counts) {
        ForEachPixel(task, camera.width, [&](size_t row, int pixel) {
          result.pixel_begin[row + 1] = counts[pixel];
        });
      });
  uint64_t total = 0;
  for (uint32_t& end : result.pixel_begin) {
    total += end;
    end = static_cast<uint32_t>(total);
  }
  if (total > std::numeric_limits<uint32_t>::max()) {
    return UnusableResultError(
        "a view of " + std::to_string(camera.width) + " x " +
        std::to_string(camera.height) + " pixels has " + std::to_string(total) +
        " blending weights, more than 32 bits can count; use smaller images");
  }

  result.gaussians.resize(total);
  result.weights.resize(total);
  lister.ForEachTile(
      [&](const TileTask& task, TileNumbers* next) {
        ForEachPixel(task, camera.width, [&](size_t row, int pixel) {
          (*next)[pixel] = result.pixel_begin[row];
        });
      },
      [&](const TileWeightList& list,
          const auto& gaussian_of,
          TileNumbers* next) {
        for (int32_t j = 0; j < list.count; ++j) {
          const uint32_t place = list.place[j];
          const uint32_t k = (*next)[TileWeightList::PixelOf(place)]++;
          result.gaussians[k] = gaussian_of(place);
          result.weights[k] = list.weight[j];
        }
      },
      [](const TileTask&, const TileNumbers&) {});
  return result;
}

}  // namespace freegs::splat
