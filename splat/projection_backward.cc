// SPDX-License-Identifier: BSD-3-Clause

#include "splat/projection_backward.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace freegs::splat {
namespace {

// Splats per task of a sum.
constexpr int64_t kGrain = 1024;

constexpr auto kPlaces = [] {
  std::array<uint32_t, ProjectionBackward::kChunk> places{};
  std::iota(places.begin(), places.end(), 0u);
  return places;
}();

}  // namespace

// In depth order, in which the pairs of each tile are read one after another.
void ProjectionBackward::SumPairs(const SplatDerivatives& from,
                                  ThreadPool& pool,
                                  std::span<float> feature_gradients) {
  const Projection& projection = *from.projection;
  const int num_depths = from.has_depth ? 1 : 0;
  const int num_features = from.num_extras - num_depths;
  const int stride = kMomentStride + from.num_extras;
  sums_.resize(projection.size());
  pool.ParallelFor(
      0,
      static_cast<int64_t>(projection.size()),
      kGrain,
      [&](int64_t begin, int64_t end, int) {
        for (int64_t s = begin; s < end; ++s) {
          SplatSums& sums = sums_[s];
          sums = SplatSums();
          // In the fixed order of the tiles.
          for (const uint32_t entry : from.bins->EntriesOf(s)) {
            const float* pair =
                from.pair_moments.data() + static_cast<size_t>(entry) * stride;
            for (int m = 0; m < kMomentStride; ++m) sums.moments[m] += pair[m];
            if (from.has_depth) sums.depth_gradient += pair[kMomentStride];
          }
          const Splat& splat = projection.splats[s];
          for (int c = 0; c < 3; ++c) {
            if (!(splat.color[c] > 0.0f)) sums.moments[kNumMoments + c] = 0;
          }
          sums.log2_opacity = splat.log2_opacity;
          if (feature_gradients.empty()) continue;
          float* features =
              feature_gradients.data() +
              static_cast<size_t>(projection.model_index[s]) * num_features;
          std::fill_n(features, num_features, 0.0f);
          for (const uint32_t entry : from.bins->EntriesOf(s)) {
            const float* pair = from.pair_moments.data() +
                                static_cast<size_t>(entry) * stride +
                                kMomentStride + num_depths;
            for (int f = 0; f < num_features; ++f) features[f] += pair[f];
          }
        }
      });
}

ProjectionBackwardTask ProjectionBackward::MakeTask(
    const SplatDerivatives& from, int64_t begin, int64_t end) const {
  ProjectionBackwardTask task;
  task.forward = from.view;
  task.count = static_cast<size_t>(end - begin);
  task.visible = from.projection->visible.data() + begin;
  task.rank = from.projection->rank.data() + begin;
  task.sums = sums_.data();
  task.mean2d_gradients = from.mean2d_gradients.data();
  return task;
}

void ProjectionBackward::ToModel(const SplatDerivatives& from,
                                 ThreadPool& pool,
                                 GaussianGradients* gradients,
                                 std::span<float> feature_gradients) {
  SumPairs(from, pool, feature_gradients);
  pool.ParallelFor(0,
                   static_cast<int64_t>(from.projection->size()),
                   kChunk,
                   [&](int64_t begin, int64_t end, int) {
                     ProjectionBackwardTask task = MakeTask(from, begin, end);
                     task.gradients = gradients;
                     task.rows = task.visible;
                     BackwardProjection(task);
                   });
}

void ProjectionBackward::InChunks(const SplatDerivatives& from,
                                  ThreadPool& pool,
                                  GradientSink sink) {
  SumPairs(from, pool, {});
  rows_.resize(pool.num_threads());
  for (GaussianGradients& rows : rows_) {
    rows.sh_degree = from.view.model->sh_degree;
    rows.Resize(kChunk);
  }
  pool.ParallelFor(0,
                   static_cast<int64_t>(from.projection->size()),
                   kChunk,
                   [&](int64_t begin, int64_t end, int worker) {
                     ProjectionBackwardTask task = MakeTask(from, begin, end);
                     task.gradients = &rows_[worker];
                     task.rows = kPlaces.data();
                     BackwardProjection(task);
                     sink({task.visible, task.count}, rows_[worker]);
                   });
}

}  // namespace freegs::splat
