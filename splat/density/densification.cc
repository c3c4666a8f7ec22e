// SPDX-License-Identifier: BSD-3-Clause

#include "splat/density/densification.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/random.h"

namespace freegs::splat {
namespace {

// The stream of the random numbers of splits; see core/random.h.
constexpr uint64_t kSplitStream = 0x73706c69740000ULL;  // "split"

constexpr int kChildren = 2;

// Pixels or Gaussians that a thread takes at once.
constexpr int64_t kGrain = 1 << 13;

enum class Fate : uint8_t { kKeep, kClone, kSplit, kBlurSplit, kPrune };

double MaxScale(const GaussianModel& model, size_t i) {
  const float* const s = &model.log_scales[3 * i];
  return std::exp(static_cast<double>(std::max({s[0], s[1], s[2]})));
}

// Both are compared as floats, so a share of exactly the limit does not exceed
// it.
bool IsBlurred(const DensificationOptions& options,
               const DensificationStatistics& statistics,
               size_t i) {
  return options.blur_split_share > 0 &&
         statistics.max_dominant_share[i] >
             static_cast<float>(options.blur_split_share);
}

// The order in which Gaussians are cloned or split while there is room: blur
// splits first, by falling share, then the others, by falling gradient.
void SortByUrgency(const DensificationOptions& options,
                   const DensificationStatistics& statistics,
                   std::vector<uint32_t>* candidates) {
  std::stable_sort(
      candidates->begin(), candidates->end(), [&](uint32_t a, uint32_t b) {
        const bool blurred_a = IsBlurred(options, statistics, a);
        const bool blurred_b = IsBlurred(options, statistics, b);
        if (blurred_a != blurred_b) return blurred_a;
        if (blurred_a) {
          return statistics.max_dominant_share[a] >
                 statistics.max_dominant_share[b];
        }
        return statistics.MeanGradient(a) > statistics.MeanGradient(b);
      });
}

// What becomes of each Gaussian. Conditions are written so that NaN is pruned.
std::vector<Fate> DecideFates(const DensificationOptions& options,
                              double scene_extent,
                              const GaussianModel& model,
                              const DensificationStatistics& statistics) {
  const size_t count = model.size();
  const double clone_max_scale = options.clone_max_scale * scene_extent;
  std::vector<Fate> fates(count, Fate::kKeep);
  std::vector<uint32_t> candidates;
  size_t kept = 0;
  for (size_t i = 0; i < count; ++i) {
    if (std::isnan(MaxScale(model, i)) ||
        !(Opacity(model, i) >= options.min_opacity)) {
      fates[i] = Fate::kPrune;
      continue;
    }
    ++kept;
    if (IsBlurred(options, statistics, i) ||
        statistics.MeanGradient(i) >= options.gradient_threshold) {
      candidates.push_back(static_cast<uint32_t>(i));
    }
  }

  size_t budget = candidates.size();
  if (options.max_gaussians > 0) {
    const auto most = static_cast<size_t>(options.max_gaussians);
    budget = std::min(budget, most - std::min(most, kept));
  }
  SortByUrgency(options, statistics, &candidates);
  candidates.resize(budget);
  for (const uint32_t i : candidates) {
    if (IsBlurred(options, statistics, i)) {
      fates[i] = Fate::kBlurSplit;
    } else {
      fates[i] =
          MaxScale(model, i) > clone_max_scale ? Fate::kSplit : Fate::kClone;
    }
  }
  return fates;
}

// Appends two Gaussians drawn from Gaussian `index`, shrunk.
void AppendChildren(const DensificationOptions& options,
                    uint64_t seed,
                    int64_t iteration,
                    const GaussianModel& model,
                    size_t index,
                    GaussianModel* added) {
  const float* const q = &model.rotations[4 * index];
  const Eigen::Quaterniond rotation =
      Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
  const uint64_t stream =
      MixBits(kSplitStream) ^ static_cast<uint64_t>(iteration);
  const float shrink = static_cast<float>(std::log(options.split_shrink));
  for (int child = 0; child < kChildren; ++child) {
    Eigen::Vector3d offset;
    for (int axis = 0; axis < 3; ++axis) {
      const uint64_t counter = (index * kChildren + child) * 3 + axis;
      offset[axis] =
          std::exp(static_cast<double>(model.log_scales[3 * index + axis])) *
          RandomNormal(seed, stream, counter);
    }
    offset = rotation * offset;
    const size_t at = added->size();
    added->AppendFrom(model, index);
    for (int axis = 0; axis < 3; ++axis) {
      added->means[3 * at + axis] += static_cast<float>(offset[axis]);
      added->log_scales[3 * at + axis] -= shrink;
    }
  }
}

}  // namespace

void DensificationStatistics::Reset(size_t count) {
  gradient_sum.assign(count, 0.0f);
  visible_steps.assign(count, 0u);
  max_dominant_share.assign(count, 0.0f);
}

void DensificationStatistics::AddView(std::span<const uint32_t> visible,
                                      std::span<const float> pixel_gradients,
                                      int width,
                                      int height,
                                      ThreadPool& pool) {
  const float half_width = 0.5f * static_cast<float>(width);
  const float half_height = 0.5f * static_cast<float>(height);
  pool.ParallelFor(0,
                   static_cast<int64_t>(visible.size()),
                   kGrain,
                   [&](int64_t begin, int64_t end, int) {
                     for (int64_t k = begin; k < end; ++k) {
                       const uint32_t i = visible[k];
                       const float x = pixel_gradients[2 * k] * half_width;
                       const float y = pixel_gradients[2 * k + 1] * half_height;
                       gradient_sum[i] += std::sqrt(x * x + y * y);
                       ++visible_steps[i];
                     }
                   });
}

void DensificationStatistics::AddDominant(const Image<int32_t>& dominant,
                                          ThreadPool& pool) {
  const size_t num_threads = pool.num_threads();
  if (pixel_counts_.size() != num_threads * size()) {
    pixel_counts_.assign(num_threads * size(), 0u);
  }
  const auto num_pixels = static_cast<int64_t>(dominant.size());
  pool.ParallelFor(
      0, num_pixels, kGrain, [&](int64_t begin, int64_t end, int worker) {
        uint32_t* const counts = pixel_counts_.data() + worker * size();
        for (int64_t k = begin; k < end; ++k) {
          // As an unsigned number -1 is larger than the size of any model.
          const auto i = static_cast<uint32_t>(dominant.data()[k]);
          if (i < size()) ++counts[i];
        }
      });
  pool.ParallelFor(
      0,
      static_cast<int64_t>(size()),
      kGrain,
      [&](int64_t begin, int64_t end, int) {
        for (int64_t i = begin; i < end; ++i) {
          uint32_t count = 0;
          for (size_t t = 0; t < num_threads; ++t) {
            count += std::exchange(pixel_counts_[t * size() + i], 0u);
          }
          if (count == 0) continue;
          const auto share = static_cast<float>(
              static_cast<double>(count) / static_cast<double>(num_pixels));
          max_dominant_share[i] = std::max(max_dominant_share[i], share);
        }
      });
}

void DensificationStatistics::Select(std::span<const uint32_t> indices) {
  const auto select = [&](auto& array) {
    auto kept = array;
    kept.resize(indices.size());
    for (size_t i = 0; i < indices.size(); ++i) kept[i] = array[indices[i]];
    array = std::move(kept);
  };
  select(gradient_sum);
  select(visible_steps);
  select(max_dominant_share);
}

Status DensificationOptions::Check() const {
  if (!(gradient_threshold >= 0)) {
    return InvalidArgumentError("gradient_threshold must be >= 0");
  }
  if (!(clone_max_scale > 0)) {
    return InvalidArgumentError("clone_max_scale must be > 0");
  }
  if (!(split_shrink >= 1 && std::isfinite(split_shrink))) {
    return InvalidArgumentError("split_shrink must be finite and >= 1");
  }
  if (!(min_opacity >= 0 && min_opacity < 1)) {
    return InvalidArgumentError("min_opacity must be in [0, 1)");
  }
  if (max_gaussians < 0) {
    return InvalidArgumentError("max_gaussians must be >= 0");
  }
  if (!(blur_split_share >= 0 && blur_split_share < 1)) {
    return InvalidArgumentError("blur_split_share must be in [0, 1)");
  }
  return Status();
}

void Densify(const DensificationOptions& options,
             double scene_extent,
             uint64_t seed,
             int64_t iteration,
             GaussianModel* model,
             Adam* adam,
             DensificationStatistics* statistics) {
  const std::vector<Fate> fates =
      DecideFates(options, scene_extent, *model, *statistics);
  std::vector<uint32_t> kept;
  GaussianModel added;
  added.sh_degree = model->sh_degree;
  for (size_t i = 0; i < fates.size(); ++i) {
    const bool keeps = fates[i] == Fate::kKeep || fates[i] == Fate::kClone;
    if (keeps) kept.push_back(static_cast<uint32_t>(i));
    if (fates[i] == Fate::kClone) added.AppendFrom(*model, i);
  }
  for (size_t i = 0; i < fates.size(); ++i) {
    if (fates[i] == Fate::kSplit || fates[i] == Fate::kBlurSplit) {
      AppendChildren(options, seed, iteration, *model, i, &added);
    }
  }
  model->Select(kept);
  for (size_t k = 0; k < added.size(); ++k) model->AppendFrom(added, k);
  adam->Select(kept);
  adam->Append(added.size());
  statistics->Reset(model->size());
}

}  // namespace freegs::splat
