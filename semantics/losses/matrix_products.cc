// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/matrix_products.h"

#include <algorithm>
#include <cstddef>

#include "semantics/losses/matrix_products_simd.h"

namespace freegs::semantics {
namespace {

// Columns of the result per task, at least a panel of the kernel.
constexpr int64_t kColumnGrain = 32;

Strided Plain(const AnyRows& matrix) {
  return {matrix.data(), static_cast<size_t>(matrix.outerStride()), 1};
}
Strided Transposed(const AnyRows& matrix) {
  return {matrix.data(), 1, static_cast<size_t>(matrix.outerStride())};
}

}  // namespace

void ApplyLayer(const AnyRows& inputs,
                const AnyRows& weights,
                std::span<const float> biases,
                Activation activation,
                ThreadPool& pool,
                Rows outputs) {
  const auto apply = [&](int64_t first, int64_t last, int) {
    for (int64_t row = 0; row < outputs.rows(); ++row) {
      float* output = outputs.row(row).data();
      if (biases.empty()) {
        std::fill(output + first, output + last, 0.0f);
      } else {
        std::copy(
            biases.begin() + first, biases.begin() + last, output + first);
      }
    }
    AddProductColumns(Plain(inputs),
                      Transposed(weights),
                      inputs.rows(),
                      inputs.cols(),
                      first,
                      last,
                      outputs.data(),
                      outputs.cols());
    if (activation == Activation::kNone) return;
    for (int64_t row = 0; row < outputs.rows(); ++row) {
      float* output = outputs.row(row).data();
      for (int64_t j = first; j < last; ++j) {
        output[j] = std::max(output[j], 0.0f);
      }
    }
  };
  pool.ParallelFor(0, outputs.cols(), kColumnGrain, apply);
}

void AddProduct(const AnyRows& a,
                const AnyRows& b,
                ThreadPool& pool,
                Rows result) {
  pool.ParallelFor(
      0, result.cols(), kColumnGrain, [&](int64_t first, int64_t last, int) {
        AddProductColumns(Plain(a),
                          Plain(b),
                          a.rows(),
                          a.cols(),
                          first,
                          last,
                          result.data(),
                          result.cols());
      });
}

void AddTransposedProduct(const AnyRows& a,
                          const AnyRows& b,
                          ThreadPool& pool,
                          Rows result) {
  pool.ParallelFor(
      0, result.cols(), kColumnGrain, [&](int64_t first, int64_t last, int) {
        AddProductColumns(Transposed(a),
                          Plain(b),
                          a.cols(),
                          a.rows(),
                          first,
                          last,
                          result.data(),
                          result.cols());
      });
}

}  // namespace freegs::semantics
