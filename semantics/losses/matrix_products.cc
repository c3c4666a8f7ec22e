// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/matrix_products.h"

namespace freegs::semantics {
namespace {

constexpr int64_t kRowGrain = 64;

}  // namespace

void ApplyLayer(const AnyRows& inputs,
                const AnyRows& weights,
                std::span<const float> biases,
                Activation activation,
                ThreadPool& pool,
                Rows outputs) {
  const Eigen::Map<const Eigen::RowVectorXf> bias(
      biases.data(), static_cast<int64_t>(biases.size()));
  pool.ParallelFor(
      0, outputs.rows(), kRowGrain, [&](int64_t first, int64_t last, int) {
        auto block = outputs.middleRows(first, last - first);
        block.noalias() =
            inputs.middleRows(first, last - first) * weights.transpose();
        if (!biases.empty()) block.rowwise() += bias;
        if (activation == Activation::kRelu) block = block.cwiseMax(0.0f);
      });
}

void AddProduct(const AnyRows& a,
                const AnyRows& b,
                ThreadPool& pool,
                Rows result) {
  pool.ParallelFor(
      0, result.rows(), kRowGrain, [&](int64_t first, int64_t last, int) {
        result.middleRows(first, last - first).noalias() +=
            a.middleRows(first, last - first) * b;
      });
}

void AddTransposedProduct(const AnyRows& a,
                          const AnyRows& b,
                          ThreadPool& pool,
                          Rows result) {
  pool.ParallelFor(
      0, result.rows(), kRowGrain, [&](int64_t first, int64_t last, int) {
        result.middleRows(first, last - first).noalias() +=
            a.middleCols(first, last - first).transpose() * b;
      });
}

}  // namespace freegs::semantics
