// SPDX-License-Identifier: BSD-3-Clause
// The mean absolute difference between rows and their targets. Both terms of
// FreeGS eq. 7 are of this form.

#ifndef FREEGS_SEMANTICS_LOSSES_L1_ROWS_H_
#define FREEGS_SEMANTICS_LOSSES_L1_ROWS_H_

#include <cstddef>
#include <span>

#include "core/function_ref.h"
#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

// Returns L = sum_p |F_p - T_p|_1 / (C P), where the sum is over the P rows
// that have a target, and adds weight dL/dF to `gradients`. The derivative is 0
// where F equals T. L is 0 when no row has a target.
//   features   F, S x C, row-major
//   target_of  T_p, C numbers, or null for a row that does not count
//   gradients  S x C
// kInvalidArgument for sizes that disagree, and for features or targets that
// are not finite; in the latter case the values added to `gradients` mean
// nothing.
StatusOr<double> L1OfRows(std::span<const float> features,
                          int channels,
                          FunctionRef<const float*(size_t row)> target_of,
                          double weight,
                          ThreadPool& pool,
                          std::span<float> gradients);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_L1_ROWS_H_
