// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/l1_rows.h"

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace freegs::semantics {
namespace {

constexpr int64_t kRowGrain = 32;

// Returns |feature - target|_1 and adds step * sign(feature - target) to the
// gradient.
double AddRow(const float* feature,
              const float* target,
              int channels,
              float step,
              float* gradient) {
  double sum = 0;
  for (int c = 0; c < channels; ++c) {
    const float difference = feature[c] - target[c];
    sum += std::abs(difference);
    const int sign = (difference > 0) - (difference < 0);
    gradient[c] += step * static_cast<float>(sign);
  }
  return sum;
}

}  // namespace

StatusOr<double> L1OfRows(std::span<const float> features,
                          int channels,
                          FunctionRef<const float*(size_t row)> target_of,
                          double weight,
                          ThreadPool& pool,
                          std::span<float> gradients) {
  if (channels <= 0 || features.size() % channels != 0 ||
      gradients.size() != features.size()) {
    return InvalidArgumentError(
        std::to_string(features.size()) + " feature values and " +
        std::to_string(gradients.size()) + " gradients, not both S x " +
        std::to_string(channels));
  }
  const size_t num_rows = features.size() / channels;
  double count = 0;
  std::vector<const float*> targets(num_rows);
  for (size_t row = 0; row < num_rows; ++row) {
    targets[row] = target_of(row);
    count += targets[row] != nullptr;
  }
  if (count == 0) return 0.0;

  const double scale = 1 / (count * channels);
  std::vector<double> losses(num_rows, 0.0);
  pool.ParallelFor(0,
                   static_cast<int64_t>(num_rows),
                   kRowGrain,
                   [&](int64_t first, int64_t last, int) {
                     for (int64_t row = first; row < last; ++row) {
                       if (targets[row] == nullptr) continue;
                       losses[row] =
                           scale * AddRow(features.data() + row * channels,
                                          targets[row],
                                          channels,
                                          static_cast<float>(weight * scale),
                                          gradients.data() + row * channels);
                     }
                   });
  double loss = 0;
  for (const double part : losses) loss += part;
  if (!std::isfinite(loss)) {
    return InvalidArgumentError("features or targets are not finite");
  }
  return loss;
}

}  // namespace freegs::semantics
