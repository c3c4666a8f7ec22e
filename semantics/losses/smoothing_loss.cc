// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/smoothing_loss.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/kd_tree.h"
#include "core/random.h"

namespace freegs::semantics {
namespace {

constexpr int64_t kQueryGrain = 512;
constexpr int64_t kPairGrain = 256;
constexpr int64_t kChannelGrain = 32;
constexpr double kMinFeatureLength = 1e-12;

// A sample and one of its neighbours. With unit vectors u, v of f_i, f_j,
//   d cos / df_i = (v - cos u) / |f_i|, and likewise for j,
// so that the gradient with respect to f_i is cross f_j + own_i f_i.
struct Pair {
  uint32_t i = 0;
  uint32_t j = 0;
  bool counts = false;
  double cosine = 0;
  double cross = 0;  // -1 / (|f_i| |f_j|)
  double own_i = 0;  // cos / |f_i|^2
  double own_j = 0;
};

double Dot(const float* a, const float* b, int dim) {
  double sum = 0;
  for (int k = 0; k < dim; ++k) sum += static_cast<double>(a[k]) * b[k];
  return sum;
}

void Compare(const float* features, int dim, Pair* pair) {
  if (pair->i == pair->j) return;  // It has no neighbours.
  const float* a = features + static_cast<size_t>(pair->i) * dim;
  const float* b = features + static_cast<size_t>(pair->j) * dim;
  const double aa = Dot(a, a, dim);
  const double bb = Dot(b, b, dim);
  // Also false if a number is not finite; the caller sees that in the cosine.
  if (aa < kMinFeatureLength * kMinFeatureLength ||
      bb < kMinFeatureLength * kMinFeatureLength)
    return;
  pair->counts = true;
  pair->cross = -1 / (std::sqrt(aa) * std::sqrt(bb));
  pair->cosine = -pair->cross * Dot(a, b, dim);
  pair->own_i = pair->cosine / aa;
  pair->own_j = pair->cosine / bb;
}

// Each task goes through all pairs in order and adds a block of channels, so
// that every sum belongs to one thread.
void AddGradients(const std::vector<Pair>& pairs,
                  std::span<const float> features,
                  int dim,
                  double scale,
                  ThreadPool& pool,
                  std::span<float> gradients) {
  pool.ParallelFor(
      0, dim, kChannelGrain, [&](int64_t first, int64_t last, int) {
        for (const Pair& pair : pairs) {
          if (!pair.counts) continue;
          const size_t row_i = static_cast<size_t>(pair.i) * dim;
          const size_t row_j = static_cast<size_t>(pair.j) * dim;
          for (int64_t k = first; k < last; ++k) {
            const double a = features[row_i + k];
            const double b = features[row_j + k];
            gradients[row_i + k] +=
                static_cast<float>(scale * (pair.cross * b + pair.own_i * a));
            gradients[row_j + k] +=
                static_cast<float>(scale * (pair.cross * a + pair.own_j * b));
          }
        }
      });
}

Status CheckSizes(std::span<const float> features,
                  int dim,
                  const NeighborTable& table,
                  std::span<const uint32_t> samples,
                  std::span<float> gradients) {
  if (dim <= 0 || features.size() != table.size() * dim ||
      gradients.size() != features.size()) {
    return InvalidArgumentError(
        std::to_string(features.size()) + " feature values and " +
        std::to_string(gradients.size()) + " gradients of " +
        std::to_string(table.size()) + " Gaussians with neighbours");
  }
  for (const uint32_t sample : samples) {
    if (sample >= table.size()) {
      return InvalidArgumentError("sample " + std::to_string(sample) + " of " +
                                  std::to_string(table.size()) + " Gaussians");
    }
  }
  return Status();
}

// The Gaussians that a k-d tree can hold, ascending.
std::vector<uint32_t> WithinReach(std::span<const float> positions) {
  std::vector<uint32_t> rows;
  for (size_t i = 0; i < positions.size() / 3; ++i) {
    const std::span<const float> position = positions.subspan(3 * i, 3);
    if (std::all_of(position.begin(), position.end(), [](float x) {
          return std::abs(x) <= KdTree::kMaxCoordinate;
        })) {
      rows.push_back(static_cast<uint32_t>(i));
    }
  }
  return rows;
}

}  // namespace

Status SmoothingOptions::Check() const {
  if (num_neighbours < 1) {
    return InvalidArgumentError("smoothing needs at least one neighbour");
  }
  if (!(fraction >= 0 && fraction <= 1)) {
    return InvalidArgumentError(
        "the fraction of Gaussians to smooth must be in [0, 1]");
  }
  if (min_samples < 0) {
    return InvalidArgumentError(
        "the least number of Gaussians to smooth must be >= 0");
  }
  return Status();
}

StatusOr<NeighborTable> BuildNeighborTable(std::span<const float> positions,
                                           int num_neighbours,
                                           ThreadPool& pool) {
  if (num_neighbours < 1) {
    return InvalidArgumentError("smoothing needs at least one neighbour");
  }
  if (positions.size() % 3 != 0) {
    return InvalidArgumentError("positions are not of three numbers each");
  }
  const std::vector<uint32_t> rows = WithinReach(positions);
  std::vector<float> near;
  near.reserve(3 * rows.size());
  for (const uint32_t row : rows) {
    near.insert(near.end(),
                &positions[3 * size_t{row}],
                &positions[3 * size_t{row}] + 3);
  }
  FREEGS_ASSIGN_OR_RETURN(const KdTree tree, KdTree::Build(near, 3));
  const auto count = static_cast<int64_t>(tree.size());
  NeighborTable table;
  if (count < 2) return table;
  table.num_neighbours =
      static_cast<int>(std::min<int64_t>(num_neighbours, count - 1));
  // Who has no neighbours stands in their places.
  table.indices.resize(positions.size() / 3 * table.num_neighbours);
  for (size_t k = 0; k < table.indices.size(); ++k) {
    table.indices[k] = static_cast<uint32_t>(k / table.num_neighbours);
  }
  pool.ParallelFor(
      0, count, kQueryGrain, [&](int64_t first, int64_t last, int) {
        std::vector<Neighbor> nearest;
        for (int64_t i = first; i < last; ++i) {
          tree.Nearest(near.data() + 3 * i,
                       table.num_neighbours,
                       static_cast<uint32_t>(i),
                       &nearest);
          for (int k = 0; k < table.num_neighbours; ++k) {
            table.indices[size_t{rows[i]} * table.num_neighbours + k] =
                rows[nearest[k].index];
          }
        }
      });
  return table;
}

std::vector<uint32_t> SampleForSmoothing(const SmoothingOptions& options,
                                         size_t count,
                                         uint64_t seed,
                                         uint64_t step) {
  const auto wanted = static_cast<size_t>(
      std::ceil(options.fraction * static_cast<double>(count)));
  const size_t num_samples = std::min(
      count, std::max(wanted, static_cast<size_t>(options.min_samples)));
  std::vector<uint32_t> samples(num_samples);
  for (size_t t = 0; t < num_samples; ++t) {
    const size_t begin = t * count / num_samples;
    const size_t end = (t + 1) * count / num_samples;
    samples[t] =
        static_cast<uint32_t>(begin + RandomIndex(seed, step, t, end - begin));
  }
  return samples;
}

StatusOr<double> SmoothingLoss(std::span<const float> features,
                               int dim,
                               const NeighborTable& table,
                               std::span<const uint32_t> samples,
                               double weight,
                               ThreadPool& pool,
                               std::span<float> gradients) {
  if (samples.empty() || table.num_neighbours == 0) return 0.0;
  FREEGS_RETURN_IF_ERROR(CheckSizes(features, dim, table, samples, gradients));
  std::vector<Pair> pairs(samples.size() * table.num_neighbours);
  pool.ParallelFor(
      0,
      static_cast<int64_t>(pairs.size()),
      kPairGrain,
      [&](int64_t first, int64_t last, int) {
        for (int64_t p = first; p < last; ++p) {
          Pair& pair = pairs[p];
          pair.i = samples[p / table.num_neighbours];
          pair.j =
              table.indices[static_cast<size_t>(pair.i) * table.num_neighbours +
                            p % table.num_neighbours];
          Compare(features.data(), dim, &pair);
        }
      });
  double sum = 0;
  int64_t count = 0;
  for (const Pair& pair : pairs) {
    if (!pair.counts) continue;
    sum += 1 - pair.cosine;
    ++count;
  }
  if (count == 0) return 0.0;
  if (!std::isfinite(sum)) {
    return InvalidArgumentError("features to smooth are not finite");
  }
  const auto pairs_counted = static_cast<double>(count);
  AddGradients(pairs, features, dim, weight / pairs_counted, pool, gradients);
  return sum / pairs_counted;
}

}  // namespace freegs::semantics
