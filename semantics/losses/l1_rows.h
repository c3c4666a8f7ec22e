// SPDX-License-Identifier: BSD-3-Clause
// The weighted mean absolute difference of rows to their targets: both terms
// of FreeGS eq. 8 are one.

#ifndef FREEGS_SEMANTICS_LOSSES_L1_ROWS_H_
#define FREEGS_SEMANTICS_LOSSES_L1_ROWS_H_

#include <cstddef>
#include <span>

#include "core/function_ref.h"
#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

// What a row is compared with. One of weight 0 does not count, and its values
// are not read.
struct TargetRow {
  const float* values = nullptr;
  float weight = 0;
};

// Returns L = sum_p w_p |F_p - T_p|_1 / (C sum_p w_p), 0 when no row counts,
// and adds weight dL/dF to `gradients`; where F equals T the derivative is 0.
//   features   S x C, row-major
//   gradients  S x C
// kInvalidArgument for sizes that disagree, for row weights that are negative
// or not finite, and for features or targets that are not finite, after which
// `gradients` are finite still but mean nothing.
StatusOr<double> L1OfRows(std::span<const float> features,
                          int channels,
                          FunctionRef<TargetRow(size_t row)> target_of,
                          double weight,
                          ThreadPool& pool,
                          std::span<float> gradients);

// The check that callers of the function above make of their row weights: one
// for each row, or none at all.
Status CheckRowWeights(std::span<const float> row_weights, size_t rows);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_L1_ROWS_H_
