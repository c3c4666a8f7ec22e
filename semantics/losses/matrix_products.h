// SPDX-License-Identifier: BSD-3-Clause
// Products of dense row-major float matrices. Threads share out fixed blocks of
// columns of the result, so that it has the same bytes for any number of
// threads, and a row is the same among others as alone. Eigen only holds the
// matrices: its own products, compiled for any x86-64, take three times as
// long, and cannot choose instructions at run time.

#ifndef FREEGS_SEMANTICS_LOSSES_MATRIX_PRODUCTS_H_
#define FREEGS_SEMANTICS_LOSSES_MATRIX_PRODUCTS_H_

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/parallel.h"

namespace freegs::semantics {

using RowMatrix =
    Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Rows = Eigen::Map<RowMatrix>;
using ConstRows = Eigen::Map<const RowMatrix>;
// Refers to either, without a copy.
using AnyRows = Eigen::Ref<const RowMatrix>;

// Views numbers as rows of `cols` > 0 numbers each. The size of `values` is a
// multiple of cols.
inline ConstRows AsRows(std::span<const float> values, int64_t cols) {
  return {values.data(), static_cast<int64_t>(values.size()) / cols, cols};
}
inline Rows AsRows(std::span<float> values, int64_t cols) {
  return {values.data(), static_cast<int64_t>(values.size()) / cols, cols};
}
inline Rows AsRows(std::vector<float>& values, int64_t cols) {
  return AsRows(std::span<float>(values), cols);
}
inline ConstRows AsRows(const std::vector<float>& values, int64_t cols) {
  return AsRows(std::span<const float>(values), cols);
}

enum class Activation { kNone, kRelu };

// outputs = activation(inputs weights^T + biases), with inputs n x k, weights m
// x k and outputs n x m. biases: m numbers, or empty for none.
void ApplyLayer(const AnyRows& inputs,
                const AnyRows& weights,
                std::span<const float> biases,
                Activation activation,
                ThreadPool& pool,
                Rows outputs);

// result += a b, with a n x k, b k x m and result n x m.
void AddProduct(const AnyRows& a,
                const AnyRows& b,
                ThreadPool& pool,
                Rows result);

// result += a^T b, with a k x n, b k x m and result n x m.
void AddTransposedProduct(const AnyRows& a,
                          const AnyRows& b,
                          ThreadPool& pool,
                          Rows result);

// Returns, for each column, the sum of value(row, column) over all rows in
// their order, in double. Threads share out the columns.
template <typename Value>
std::vector<double> ColumnSums(int64_t rows,
                               int64_t cols,
                               ThreadPool& pool,
                               const Value& value) {
  constexpr int64_t kColumnGrain = 32;
  std::vector<double> sums(cols, 0.0);
  pool.ParallelFor(
      0, cols, kColumnGrain, [&](int64_t first, int64_t last, int) {
        for (int64_t row = 0; row < rows; ++row) {
          for (int64_t col = first; col < last; ++col) {
            sums[col] += value(row, col);
          }
        }
      });
  return sums;
}

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_MATRIX_PRODUCTS_H_
