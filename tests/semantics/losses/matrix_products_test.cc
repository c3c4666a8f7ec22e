// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/matrix_products.h"

#include <vector>

#include <gtest/gtest.h>

#include "tests/semantics/losses/gradient_check.h"

namespace freegs::semantics {
namespace {

struct Sizes {
  int64_t n;
  int64_t m;
  int64_t k;
};

// Whole blocks, parts of them, more terms than go at a time, one row, and none.
constexpr Sizes kSizes[] = {{64, 32, 16},
                            {131, 37, 19},
                            {9, 70, 600},
                            {1, 5, 3},
                            {70, 1, 129},
                            {3, 4, 0},
                            {0, 4, 3}};

Eigen::MatrixXd Random(int64_t rows, int64_t cols, uint64_t seed) {
  const std::vector<float> values = RandomValues(rows * cols, seed);
  return Eigen::Map<const RowMatrix>(values.data(), rows, cols).cast<double>();
}

void ExpectNear(const RowMatrix& result, const Eigen::MatrixXd& expected) {
  ASSERT_EQ(result.rows(), expected.rows());
  ASSERT_EQ(result.cols(), expected.cols());
  for (int64_t i = 0; i < result.rows(); ++i) {
    for (int64_t j = 0; j < result.cols(); ++j) {
      ASSERT_NEAR(result(i, j), expected(i, j), 1e-4) << i << ", " << j;
    }
  }
}

Rows RowsOf(RowMatrix& matrix) {
  return {matrix.data(), matrix.rows(), matrix.cols()};
}

TEST(MatrixProducts, AgreeWithProductsInDouble) {
  ThreadPool pool(2);
  for (const Sizes& size : kSizes) {
    const Eigen::MatrixXd a = Random(size.n, size.k, 1);
    const Eigen::MatrixXd b = Random(size.k, size.m, 2);
    const Eigen::MatrixXd start = Random(size.n, size.m, 3);
    const Eigen::MatrixXd product = a * b;
    const RowMatrix a_float = a.cast<float>();
    const RowMatrix b_float = b.cast<float>();
    const RowMatrix a_transposed = a.transpose().cast<float>();
    const RowMatrix b_transposed = b.transpose().cast<float>();

    RowMatrix result = start.cast<float>();
    AddProduct(a_float, b_float, pool, RowsOf(result));
    ExpectNear(result, start + product);

    result = start.cast<float>();
    AddTransposedProduct(a_transposed, b_float, pool, RowsOf(result));
    ExpectNear(result, start + product);

    const std::vector<float> biases = RandomValues(size.m, 4);
    Eigen::MatrixXd expected = product;
    ApplyLayer(
        a_float, b_transposed, {}, Activation::kNone, pool, RowsOf(result));
    ExpectNear(result, expected);
    for (int64_t j = 0; j < size.m; ++j) expected.col(j).array() += biases[j];
    ApplyLayer(
        a_float, b_transposed, biases, Activation::kRelu, pool, RowsOf(result));
    ExpectNear(result, expected.cwiseMax(0));
  }
}

TEST(MatrixProducts, AreTheSameBytesForAnyNumberOfThreads) {
  const RowMatrix a = Random(301, 131, 1).cast<float>();
  const RowMatrix b = Random(131, 203, 2).cast<float>();
  const RowMatrix c = Random(301, 203, 3).cast<float>();
  std::vector<RowMatrix> products;
  std::vector<RowMatrix> transposed;
  std::vector<RowMatrix> layers;
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    products.push_back(RowMatrix::Zero(301, 203));
    AddProduct(a, b, pool, RowsOf(products.back()));
    transposed.push_back(RowMatrix::Zero(131, 203));
    AddTransposedProduct(a, c, pool, RowsOf(transposed.back()));
    layers.push_back(RowMatrix::Zero(301, 131));
    ApplyLayer(c, b, {}, Activation::kNone, pool, RowsOf(layers.back()));
  }
  for (size_t k = 1; k < products.size(); ++k) {
    EXPECT_EQ(products[k], products[0]);
    EXPECT_EQ(transposed[k], transposed[0]);
    EXPECT_EQ(layers[k], layers[0]);
  }
}

TEST(MatrixProducts, ColumnSumsAreInDouble) {
  ThreadPool pool(3);
  const std::vector<double> sums =
      ColumnSums(1000, 70, pool, [](int64_t row, int64_t col) {
        return row == 0 ? 1e16 : static_cast<double>(col % 2 ? 2 : 0);
      });
  for (int64_t col = 0; col < 70; ++col) {
    EXPECT_EQ(sums[col], 1e16 + (col % 2 ? 1998 : 0));
  }
  EXPECT_EQ(ColumnSums(0, 2, pool, [](int64_t, int64_t) { return 1.0; }),
            (std::vector<double>{0, 0}));
}

}  // namespace
}  // namespace freegs::semantics
