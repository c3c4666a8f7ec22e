// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/instance_distillation_loss.h"

#include <string>

#include "semantics/losses/l1_rows.h"

namespace freegs::semantics {
namespace {

Status CheckInstances(std::span<const int32_t> ids,
                      const InstanceTargets& instances,
                      int channels) {
  if (instances.features.size() != instances.known.size() * channels) {
    return InvalidArgumentError(std::to_string(instances.features.size()) +
                                " values for the features of " +
                                std::to_string(instances.known.size()) +
                                " instances");
  }
  for (const int32_t id : ids) {
    if (id >= 0 && static_cast<size_t>(id) >= instances.known.size()) {
      return InvalidArgumentError(
          "a pixel of instance " + std::to_string(id) + " where there are " +
          std::to_string(instances.known.size()) + " instances");
    }
  }
  return Status();
}

}  // namespace

StatusOr<double> InstanceDistillationLoss(std::span<const float> decoded,
                                          int channels,
                                          std::span<const int32_t> ids,
                                          const InstanceTargets& instances,
                                          double weight,
                                          ThreadPool& pool,
                                          std::span<float> gradients) {
  if (channels <= 0 || decoded.size() != ids.size() * channels) {
    return InvalidArgumentError(std::to_string(decoded.size()) +
                                " decoded values for " +
                                std::to_string(ids.size()) + " instance ids");
  }
  FREEGS_RETURN_IF_ERROR(CheckInstances(ids, instances, channels));
  return L1OfRows(
      decoded,
      channels,
      [&](size_t row) -> const float* {
        const int32_t id = ids[row];
        if (id < 0 || !instances.known[id]) return nullptr;
        return instances.features.data() + static_cast<size_t>(id) * channels;
      },
      weight,
      pool,
      gradients);
}

}  // namespace freegs::semantics
