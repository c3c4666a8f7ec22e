// SPDX-License-Identifier: BSD-3-Clause

#include "splat/render/projection_backward.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace freegs::splat {
namespace {

constexpr auto kPlaces = [] {
  std::array<uint32_t, ProjectionBackward::kChunk> places{};
  std::iota(places.begin(), places.end(), 0u);
  return places;
}();

// Adds up the numbers of the entries of a splat, from number `first` of each
// entry on. The order is that of the tiles, so the sum is always the same.
template <size_t kExtent>
void AddPairs(const SplatDerivatives& from,
              int64_t place,
              int first,
              std::span<float, kExtent> sums) {
  const size_t stride = kMomentStride + from.num_extras;
  for (const uint32_t entry : from.bins->EntriesOf(place)) {
    const float* pair = from.pair_moments.data() + entry * stride + first;
    for (size_t m = 0; m < sums.size(); ++m) sums[m] += pair[m];
  }
}

SplatSums SumsOf(const SplatDerivatives& from, int64_t place) {
  SplatSums sums = {};
  AddPairs(from, place, 0, std::span(sums.moments));
  if (from.has_depth) {
    AddPairs(from, place, kMomentStride, std::span(&sums.depth_gradient, 1));
  }
  const Splat& splat = from.projection->SplatAt(place);
  for (int c = 0; c < 3; ++c) {
    if (!(splat.color[c] > 0.0f)) sums.moments[kNumMoments + c] = 0;
  }
  return sums;
}

void SumFeatures(const SplatDerivatives& from,
                 int64_t place,
                 std::span<float> feature_gradients) {
  const int num_depths = from.has_depth ? 1 : 0;
  const size_t num_features = from.num_extras - num_depths;
  const auto features = feature_gradients.subspan(
      from.projection->visible[place] * num_features, num_features);
  std::fill(features.begin(), features.end(), 0.0f);
  AddPairs(from, place, kMomentStride + num_depths, features);
}

// The sums of a chunk of places.
using ChunkSums = std::array<SplatSums, ProjectionBackward::kChunk>;

// The task for the places [begin, end) of projection->visible. `sums` receives
// their sums, and must live as long as the task. The gradients are not set.
ProjectionBackwardTask MakeTask(const SplatDerivatives& from,
                                int64_t begin,
                                int64_t end,
                                ChunkSums* sums) {
  for (int64_t place = begin; place < end; ++place) {
    (*sums)[place - begin] = SumsOf(from, place);
  }
  ProjectionBackwardTask task;
  task.forward = from.view;
  task.count = static_cast<size_t>(end - begin);
  task.visible = from.projection->visible.data() + begin;
  task.sums = sums->data();
  task.mean2d_gradients = from.mean2d_gradients.data() + 2 * begin;
  return task;
}

}  // namespace

void ProjectionBackward::ToModel(const SplatDerivatives& from,
                                 ThreadPool& pool,
                                 GaussianGradients* gradients,
                                 std::span<float> feature_gradients) {
  pool.ParallelFor(0,
                   static_cast<int64_t>(from.projection->size()),
                   kChunk,
                   [&](int64_t begin, int64_t end, int) {
                     ChunkSums sums;
                     ProjectionBackwardTask task =
                         MakeTask(from, begin, end, &sums);
                     task.gradients = gradients;
                     task.rows = task.visible;
                     BackwardProjection(task);
                     if (feature_gradients.empty()) return;
                     for (int64_t place = begin; place < end; ++place) {
                       SumFeatures(from, place, feature_gradients);
                     }
                   });
}

void ProjectionBackward::InChunks(const SplatDerivatives& from,
                                  ThreadPool& pool,
                                  GradientSink sink) {
  rows_.resize(pool.num_threads());
  for (GaussianGradients& rows : rows_) {
    rows.sh_degree = from.view.model->sh_degree;
    rows.Resize(kChunk);
  }
  pool.ParallelFor(0,
                   static_cast<int64_t>(from.projection->size()),
                   kChunk,
                   [&](int64_t begin, int64_t end, int worker) {
                     ChunkSums sums;
                     ProjectionBackwardTask task =
                         MakeTask(from, begin, end, &sums);
                     task.gradients = &rows_[worker];
                     task.rows = kPlaces.data();
                     BackwardProjection(task);
                     sink({task.visible, task.count}, rows_[worker]);
                   });
}

}  // namespace freegs::splat
