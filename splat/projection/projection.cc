// SPDX-License-Identifier: BSD-3-Clause

#include "splat/projection/projection.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include <hwy/cache_control.h>

namespace freegs::splat {
namespace {

constexpr int64_t kChunk = 1024;

// A splat is requested from memory so many splats before it is read.
constexpr int64_t kAhead = 16;

// Stable radix sort by the upper 32 bits of the keys, 11 bits a pass.
void SortByDepth(std::vector<uint64_t>* keys, std::vector<uint64_t>* scratch) {
  constexpr int kBits = 11;
  constexpr size_t kBuckets = size_t{1} << kBits;
  scratch->resize(keys->size());
  std::array<uint32_t, kBuckets> starts;
  for (int shift = 32; shift < 64; shift += kBits) {
    std::fill(starts.begin(), starts.end(), 0);
    for (const uint64_t key : *keys) {
      ++starts[(key >> shift) & (kBuckets - 1)];
    }
    uint32_t sum = 0;
    for (uint32_t& start : starts) sum += std::exchange(start, sum);
    for (const uint64_t key : *keys) {
      (*scratch)[starts[(key >> shift) & (kBuckets - 1)]++] = key;
    }
    keys->swap(*scratch);
  }
}

}  // namespace

template <typename T>
ProjectionCamera<T> MakeProjectionCamera(const Pinhole& camera,
                                         const Rigid3d& cam_from_world,
                                         const RenderOptions& options) {
  ProjectionCamera<T> result;
  const Eigen::Matrix3d rotation = cam_from_world.rotation.toRotationMatrix();
  const Eigen::Vector3d centre = CameraCentre(cam_from_world);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      result.rotation[3 * i + j] = static_cast<T>(rotation(i, j));
    }
    result.translation[i] = static_cast<T>(cam_from_world.translation[i]);
    result.centre[i] = static_cast<T>(centre[i]);
  }
  result.fx = static_cast<T>(camera.fx);
  result.fy = static_cast<T>(camera.fy);
  result.cx = static_cast<T>(camera.cx);
  result.cy = static_cast<T>(camera.cy);
  // The image plus 15 % of its size on each side, as in 3DGS.
  const double margin_u = 0.15 * camera.width / camera.fx;
  const double margin_v = 0.15 * camera.height / camera.fy;
  result.min_u = static_cast<T>(-camera.cx / camera.fx - margin_u);
  result.max_u =
      static_cast<T>((camera.width - camera.cx) / camera.fx + margin_u);
  result.min_v = static_cast<T>(-camera.cy / camera.fy - margin_v);
  result.max_v =
      static_cast<T>((camera.height - camera.cy) / camera.fy + margin_v);
  result.near_plane = static_cast<T>(options.near_plane);
  result.dilation = static_cast<T>(options.dilation);
  return result;
}

template ProjectionCamera<float> MakeProjectionCamera(const Pinhole&,
                                                      const Rigid3d&,
                                                      const RenderOptions&);
template ProjectionCamera<double> MakeProjectionCamera(const Pinhole&,
                                                       const Rigid3d&,
                                                       const RenderOptions&);

ProjectionTask MakeProjectionTask(const GaussianModel& model,
                                  const Pinhole& camera,
                                  const Rigid3d& cam_from_world,
                                  const RenderOptions& options) {
  return {&model,
          MakeProjectionCamera<float>(camera, cam_from_world, options),
          camera.width,
          camera.height,
          std::min(options.sh_degree, model.sh_degree)};
}

void Projector::Project(const GaussianModel& model,
                        const Pinhole& camera,
                        const Rigid3d& cam_from_world,
                        const RenderOptions& options,
                        ThreadPool& pool,
                        Projection* projection) {
  const ProjectionTask task =
      MakeProjectionTask(model, camera, cam_from_world, options);
  const auto count = static_cast<int64_t>(model.size());
  by_model_.resize(model.size());
  visible_.resize(model.size());
  chunk_counts_.assign((model.size() + kChunk - 1) / kChunk, 0);
  pool.ParallelFor(0, count, kChunk, [&](int64_t begin, int64_t end, int) {
    chunk_counts_[begin / kChunk] = static_cast<uint32_t>(
        ProjectRange(task, begin, end, by_model_.data(), &visible_[begin]));
  });

  keys_.clear();
  projection->visible.clear();
  for (size_t chunk = 0; chunk < chunk_counts_.size(); ++chunk) {
    for (uint32_t k = 0; k < chunk_counts_[chunk]; ++k) {
      const uint32_t i = visible_[chunk * kChunk + k];
      // Positive floats sort as their bits.
      const auto depth = std::bit_cast<uint32_t>(by_model_[i].depth);
      keys_.push_back(static_cast<uint64_t>(depth) << 32 |
                      projection->visible.size());
      projection->visible.push_back(i);
    }
  }
  SortByDepth(&keys_, &keys_scratch_);

  projection->splats.resize(keys_.size());
  projection->model_index.resize(keys_.size());
  projection->rank.resize(keys_.size());
  pool.ParallelFor(0,
                   static_cast<int64_t>(keys_.size()),
                   kChunk,
                   [&](int64_t begin, int64_t end, int) {
                     for (int64_t k = begin; k < end; ++k) {
                       // In the order of depth they lie scattered in memory.
                       const auto ahead = static_cast<uint32_t>(
                           keys_[std::min(k + kAhead, end - 1)]);
                       hwy::Prefetch(&by_model_[projection->visible[ahead]]);
                       const auto j = static_cast<uint32_t>(keys_[k]);
                       const uint32_t i = projection->visible[j];
                       projection->rank[j] = static_cast<uint32_t>(k);
                       projection->model_index[k] = i;
                       projection->splats[k] = by_model_[i];
                     }
                   });
}

}  // namespace freegs::splat
