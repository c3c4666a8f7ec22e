// SPDX-License-Identifier: BSD-3-Clause

#include "splat/projection/projection.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

namespace freegs::splat {
namespace {

constexpr int64_t kChunk = 1024;

// A radix sort takes so many bits a pass.
constexpr int kRadixBits = 11;
constexpr size_t kBuckets = size_t{1} << kRadixBits;

size_t BucketOf(uint64_t key, int shift) {
  return (key >> shift) & (kBuckets - 1);
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

// A stable radix sort by the upper 32 bits of the keys. Each thread counts and
// moves the keys of its own part; the places of the parts within a bucket
// follow each other, so the result does not depend on the number of parts.
void Projector::SortByDepth(ThreadPool& pool, std::vector<uint32_t>* by_depth) {
  const auto count = static_cast<int64_t>(keys_.size());
  const int64_t parts = pool.num_threads();
  const int64_t part_size = std::max<int64_t>(1, (count + parts - 1) / parts);
  keys_scratch_.resize(keys_.size());
  buckets_.resize(parts * kBuckets);
  for (int shift = 32; shift < 64; shift += kRadixBits) {
    std::fill(buckets_.begin(), buckets_.end(), 0);
    pool.ParallelFor(0, count, part_size, [&](int64_t begin, int64_t end, int) {
      uint32_t* const counts = &buckets_[begin / part_size * kBuckets];
      for (int64_t k = begin; k < end; ++k) {
        ++counts[BucketOf(keys_[k], shift)];
      }
    });
    uint32_t sum = 0;
    for (size_t bucket = 0; bucket < kBuckets; ++bucket) {
      for (int64_t part = 0; part < parts; ++part) {
        sum += std::exchange(buckets_[part * kBuckets + bucket], sum);
      }
    }
    pool.ParallelFor(0, count, part_size, [&](int64_t begin, int64_t end, int) {
      uint32_t* const places = &buckets_[begin / part_size * kBuckets];
      for (int64_t k = begin; k < end; ++k) {
        keys_scratch_[places[BucketOf(keys_[k], shift)]++] = keys_[k];
      }
    });
    keys_.swap(keys_scratch_);
  }
  by_depth->resize(keys_.size());
  for (size_t k = 0; k < keys_.size(); ++k) {
    (*by_depth)[k] = static_cast<uint32_t>(keys_[k]);
  }
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
  projection->splats.resize(model.size());
  found_.resize(model.size());
  chunk_begin_.assign((model.size() + kChunk - 1) / kChunk + 1, 0);
  pool.ParallelFor(0, count, kChunk, [&](int64_t begin, int64_t end, int) {
    chunk_begin_[begin / kChunk + 1] = static_cast<uint32_t>(ProjectRange(
        task, begin, end, projection->splats.data(), &found_[begin]));
  });
  std::partial_sum(
      chunk_begin_.begin(), chunk_begin_.end(), chunk_begin_.begin());

  projection->visible.resize(chunk_begin_.back());
  keys_.resize(chunk_begin_.back());
  pool.ParallelFor(0, count, kChunk, [&](int64_t begin, int64_t, int) {
    const int64_t chunk = begin / kChunk;
    const uint32_t* found = &found_[begin];
    for (uint32_t j = chunk_begin_[chunk]; j < chunk_begin_[chunk + 1]; ++j) {
      const uint32_t i = *found++;
      projection->visible[j] = i;
      // Positive floats sort as their bits.
      const auto depth = std::bit_cast<uint32_t>(projection->splats[i].depth);
      keys_[j] = static_cast<uint64_t>(depth) << 32 | j;
    }
  });
  SortByDepth(pool, &projection->by_depth);
}

}  // namespace freegs::splat
