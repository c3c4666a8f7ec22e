// SPDX-License-Identifier: BSD-3-Clause
// The vectorised kernel of the products in matrix_products.h.

#ifndef FREEGS_SEMANTICS_LOSSES_MATRIX_PRODUCTS_SIMD_H_
#define FREEGS_SEMANTICS_LOSSES_MATRIX_PRODUCTS_SIMD_H_

#include <cstddef>

namespace freegs::semantics {

// A matrix or the transpose of one: entry (i, j) is data[i * row_step + j *
// col_step].
struct Strided {
  const float* data;
  size_t row_step;
  size_t col_step;
};

// Adds sum_k a(i, k) b(k, j) to result(i, j), for all rows i and for the
// columns j in [first, last). The result is row-major with `cols` columns.
// Terms are summed in order, 256 at a time, whatever rows and columns are asked
// for.
void AddProductColumns(const Strided& a,
                       const Strided& b,
                       size_t rows,
                       size_t terms,
                       size_t first,
                       size_t last,
                       float* result,
                       size_t cols);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_MATRIX_PRODUCTS_SIMD_H_
