// SPDX-License-Identifier: BSD-3-Clause

#include "splat/weights/pixel_weights.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <string>

#include "splat/projection/projection.h"
#include "splat/projection/projection_simd.h"
#include "splat/weights/tile_weights_simd.h"

namespace freegs::splat {
namespace {

constexpr int64_t kChunk = 4096;

struct CoveringSplat {
  uint32_t gaussian;
  Splat splat;
};

// The Gaussians whose box holds the pixel, nearest first, ties by index.
std::vector<CoveringSplat> FindCovering(const ProjectionTask& task,
                                        int x,
                                        int y,
                                        ThreadPool& pool) {
  const auto count = static_cast<int64_t>(task.model->size());
  // Uninitialised: only the splats of visible Gaussians are written and read.
  const auto splats = std::make_unique_for_overwrite<Splat[]>(count);
  const auto visible = std::make_unique_for_overwrite<uint32_t[]>(count);
  std::vector<std::vector<CoveringSplat>> chunks((count + kChunk - 1) / kChunk);
  pool.ParallelFor(0, count, kChunk, [&](int64_t begin, int64_t end, int) {
    const size_t found =
        ProjectRange(task, begin, end, splats.get(), &visible[begin]);
    for (size_t k = 0; k < found; ++k) {
      const uint32_t i = visible[begin + k];
      const Splat& splat = splats[i];
      if (x >= splat.x_begin && x < splat.x_end && y >= splat.y_begin &&
          y < splat.y_end) {
        chunks[begin / kChunk].push_back({i, splat});
      }
    }
  });
  std::vector<CoveringSplat> covering;
  for (const std::vector<CoveringSplat>& chunk : chunks) {
    covering.insert(covering.end(), chunk.begin(), chunk.end());
  }
  std::stable_sort(covering.begin(),
                   covering.end(),
                   [](const CoveringSplat& a, const CoveringSplat& b) {
                     return a.splat.depth < b.splat.depth;
                   });
  return covering;
}

}  // namespace

StatusOr<std::vector<PixelWeight>> ComputePixelWeights(
    const GaussianModel& model,
    const Pinhole& camera,
    const Rigid3d& cam_from_world,
    const RenderOptions& options,
    int x,
    int y,
    ThreadPool& pool) {
  if (x < 0 || y < 0 || x >= camera.width || y >= camera.height) {
    return InvalidArgumentError("pixel (" + std::to_string(x) + ", " +
                                std::to_string(y) + ") is not in an image of " +
                                std::to_string(camera.width) + " x " +
                                std::to_string(camera.height));
  }
  RenderOptions colorless = options;
  colorless.sh_degree = 0;
  const std::vector<CoveringSplat> covering = FindCovering(
      MakeProjectionTask(model, camera, cam_from_world, colorless), x, y, pool);

  // The pixel's tile with only those splats that may touch the pixel.
  std::vector<Splat> splats(covering.size());
  for (size_t k = 0; k < covering.size(); ++k) splats[k] = covering[k].splat;
  std::vector<uint32_t> entries(covering.size());
  std::iota(entries.begin(), entries.end(), 0);
  TileTask task;
  task.splats = splats.data();
  task.entries = entries.data();
  task.count = static_cast<int64_t>(entries.size());
  task.x0 = x / kTileSize * kTileSize;
  task.y0 = y / kTileSize * kTileSize;
  task.width = std::min(kTileSize, camera.width - task.x0);
  task.height = std::min(kTileSize, camera.height - task.y0);

  const auto pixel = static_cast<uint32_t>(TilePixel(
      static_cast<unsigned>(x - task.x0), static_cast<unsigned>(y - task.y0)));
  const auto list = std::make_unique<TileWeightList>();
  alignas(64) float transmittance[kTilePixels];
  std::vector<PixelWeight> weights;
  for (int64_t begin = 0; begin < task.count;) {
    const int64_t next =
        ListTileWeights(task, begin, transmittance, list.get());
    for (int32_t j = 0; j < list->count; ++j) {
      const uint32_t place = list->place[j];
      if (TileWeightList::PixelOf(place) != pixel) continue;
      const CoveringSplat& source =
          covering[begin + TileWeightList::EntryOf(place)];
      weights.push_back({source.gaussian, list->weight[j], source.splat.depth});
    }
    begin = next;
  }
  return weights;
}

}  // namespace freegs::splat
