// SPDX-License-Identifier: BSD-3-Clause
// Distillation of instance features: the second term of FreeGS eq. 7, without
// its factor gamma.

#ifndef FREEGS_SEMANTICS_LOSSES_INSTANCE_DISTILLATION_LOSS_H_
#define FREEGS_SEMANTICS_LOSSES_INSTANCE_DISTILLATION_LOSS_H_

#include <cstdint>
#include <span>

#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

// The features that CLIP gives to the instances (FreeGS eq. 6).
struct InstanceTargets {
  std::span<const float> features;  // Instances x C, row-major.
  std::span<const uint8_t> known;   // Per instance: 0 if it has no feature.
};

// Returns L = sum_p |F_p - T_id(p)|_1 / (C P) and adds weight dL/dF to
// `gradients`. The sum is over the P pixels whose instance has a feature; L is
// 0 if there are none. FreeGS has zeros as features elsewhere, which would draw
// the features of pixels without an instance to zero.
//   decoded    F, S x C, row-major
//   ids        S: row of the instance at the pixel, negative for none
//   gradients  S x C
// kInvalidArgument for sizes that disagree, ids beyond the table and values
// that are not finite.
StatusOr<double> InstanceDistillationLoss(std::span<const float> decoded,
                                          int channels,
                                          std::span<const int32_t> ids,
                                          const InstanceTargets& instances,
                                          double weight,
                                          ThreadPool& pool,
                                          std::span<float> gradients);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_INSTANCE_DISTILLATION_LOSS_H_
