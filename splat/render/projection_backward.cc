// SPDX-License-Identifier: BSD-3-Clause

#include "splat/render/projection_backward.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace freegs::splat {
namespace {

// How many splats a task sums up.
constexpr int64_t kGrain = 1024;

constexpr auto kPlaces = [] {
  std::array<uint32_t, ProjectionBackward::kChunk> places{};
  std::iota(places.begin(), places.end(), 0u);
  return places;
}();

// Adds up the numbers of the entries of a splat, from number `first` of each
// entry on. The order is that of the tiles, so the sum is always the same.
template <size_t kExtent>
void AddPairs(const SplatDerivatives& from,
              int64_t splat,
              int first,
              std::span<float, kExtent> sums) {
  const size_t stride = kMomentStride + from.num_extras;
  for (const uint32_t entry : from.bins->EntriesOf(splat)) {
    const float* pair = from.pair_moments.data() + entry * stride + first;
    for (size_t m = 0; m < sums.size(); ++m) sums[m] += pair[m];
  }
}

SplatSums SumsOf(const SplatDerivatives& from, int64_t s) {
  SplatSums sums = {};
  AddPairs(from, s, 0, std::span(sums.moments));
  if (from.has_depth) {
    AddPairs(from, s, kMomentStride, std::span(&sums.depth_gradient, 1));
  }
  const Splat& splat = from.projection->splats[s];
  for (int c = 0; c < 3; ++c) {
    if (!(splat.color[c] > 0.0f)) sums.moments[kNumMoments + c] = 0;
  }
  sums.log2_opacity = splat.log2_opacity;
  return sums;
}

}  // namespace

// In the order of depth the entries of each tile are read one after another.
void ProjectionBackward::SumPairs(const SplatDerivatives& from,
                                  ThreadPool& pool,
                                  std::span<float> feature_gradients) {
  const Projection& projection = *from.projection;
  const int num_depths = from.has_depth ? 1 : 0;
  const size_t num_features = from.num_extras - num_depths;
  sums_.resize(projection.size());
  pool.ParallelFor(0,
                   static_cast<int64_t>(projection.size()),
                   kGrain,
                   [&](int64_t begin, int64_t end, int) {
                     for (int64_t s = begin; s < end; ++s) {
                       sums_[s] = SumsOf(from, s);
                       if (feature_gradients.empty()) continue;
                       const auto features = feature_gradients.subspan(
                           projection.model_index[s] * num_features,
                           num_features);
                       std::fill(features.begin(), features.end(), 0.0f);
                       AddPairs(from, s, kMomentStride + num_depths, features);
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
