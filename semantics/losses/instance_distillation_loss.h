// SPDX-License-Identifier: BSD-3-Clause
// Instance-level feature distillation (FreeGS eq. 8, second term, without its
// factor gamma).

#ifndef FREEGS_SEMANTICS_LOSSES_INSTANCE_DISTILLATION_LOSS_H_
#define FREEGS_SEMANTICS_LOSSES_INSTANCE_DISTILLATION_LOSS_H_

#include <cstdint>
#include <span>

#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

// What CLIP says of the instances of one view (FreeGS eq. 7).
struct InstanceTargets {
  std::span<const float> features;  // Instances x C, row-major.
  std::span<const uint8_t> known;   // Per instance: 0 when it has no feature.
};

// Returns L = sum_p w_p |F_p - T_id(p)|_1 / (C sum_p w_p) and adds
// weight dL/dF to `gradients`; the sums are over the pixels that count: those
// of an instance that has a feature. 0 when there is none. In FreeGS F_ins is
// zero elsewhere, and features of pixels without an instance would be drawn to
// zero.
//   decoded      F, S x C, row-major
//   ids          S: row of the instance at the pixel, negative for none
//   row_weights  w, S, >= 0; empty: all 1
//   gradients    S x C
// kInvalidArgument for sizes that disagree, ids beyond the table, row weights
// out of range and values that are not finite.
StatusOr<double> InstanceDistillationLoss(std::span<const float> decoded,
                                          int channels,
                                          std::span<const int32_t> ids,
                                          const InstanceTargets& instances,
                                          double weight,
                                          ThreadPool& pool,
                                          std::span<float> gradients);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_INSTANCE_DISTILLATION_LOSS_H_
