// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/pixel_distillation_loss.h"

#include <string>

#include "semantics/losses/l1_rows.h"

namespace freegs::semantics {

StatusOr<double> PixelDistillationLoss(std::span<const float> decoded,
                                       std::span<const float> targets,
                                       int channels,
                                       double weight,
                                       ThreadPool& pool,
                                       std::span<float> gradients) {
  if (channels <= 0 || targets.size() != decoded.size()) {
    return InvalidArgumentError(std::to_string(decoded.size()) +
                                " decoded values for " +
                                std::to_string(targets.size()) + " targets");
  }
  return L1OfRows(
      decoded,
      channels,
      [&](size_t row) { return targets.data() + row * channels; },
      weight,
      pool,
      gradients);
}

}  // namespace freegs::semantics
