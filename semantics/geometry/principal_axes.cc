// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/geometry/principal_axes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <string>

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace freegs::semantics {
namespace {

using RowMatrix =
    Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using ConstRows = Eigen::Map<const RowMatrix>;
using Rows = Eigen::Map<RowMatrix>;

constexpr int64_t kRowBlock = 1024;
constexpr int64_t kColumnBlock = 32;

// out = a b. All products of this file are this one function, because each
// shape of a product that Eigen compiles takes seconds.
void Multiply(const RowMatrix& a, ConstRows b, Rows out) {
  out.noalias() = a * b;
}

std::vector<float> MeanOf(ConstRows rows, ThreadPool& pool) {
  std::vector<float> mean(rows.cols());
  pool.ParallelFor(
      0, rows.cols(), kColumnBlock, [&](int64_t first, int64_t last, int) {
        for (int64_t c = first; c < last; ++c) {
          mean[c] = static_cast<float>(rows.col(c).cast<double>().sum() /
                                       static_cast<double>(rows.rows()));
        }
      });
  return mean;
}

// The mean of (row - mean)^T (row - mean). Threads share out columns, so that
// every sum is one thread's and in one order.
Eigen::MatrixXd SecondMoments(ConstRows rows,
                              const std::vector<float>& mean,
                              ThreadPool& pool) {
  const Eigen::Map<const Eigen::RowVectorXf> center(mean.data(), rows.cols());
  Eigen::MatrixXd moments = Eigen::MatrixXd::Zero(rows.cols(), rows.cols());
  RowMatrix block;
  for (int64_t begin = 0; begin < rows.rows(); begin += kRowBlock) {
    const int64_t count = std::min(kRowBlock, rows.rows() - begin);
    block = rows.middleRows(begin, count).rowwise() - center;
    const ConstRows all(block.data(), count, rows.cols());
    pool.ParallelFor(
        0, rows.cols(), kColumnBlock, [&](int64_t first, int64_t last, int) {
          const int64_t size = last - first;
          RowMatrix product(size, rows.cols());
          Multiply(block.middleCols(first, size).transpose(),
                   all,
                   Rows(product.data(), size, rows.cols()));
          moments.middleCols(first, size) += product.transpose().cast<double>();
        });
  }
  return moments / static_cast<double>(rows.rows());
}

}  // namespace

void PrincipalAxes::Keep(int first) {
  if (first >= count) return;
  count = first;
  axes.resize(static_cast<size_t>(count) * dim);
}

StatusOr<PrincipalAxes> ComputePrincipalAxes(std::span<const float> rows,
                                             int dim,
                                             bool about_mean,
                                             ThreadPool& pool) {
  if (dim <= 0 || rows.empty() || rows.size() % dim != 0) {
    return InvalidArgumentError(
        "principal axes need vectors of one size, at least one of them; there "
        "are " +
        std::to_string(rows.size()) + " numbers for size " +
        std::to_string(dim));
  }
  if (!std::all_of(
          rows.begin(), rows.end(), [](float x) { return std::isfinite(x); })) {
    return InvalidArgumentError("principal axes of values that are not finite");
  }
  const ConstRows matrix(
      rows.data(), static_cast<int64_t>(rows.size()) / dim, dim);
  PrincipalAxes result;
  result.dim = result.count = dim;
  result.mean =
      about_mean ? MeanOf(matrix, pool) : std::vector<float>(dim, 0.0f);
  Eigen::MatrixXd moments = SecondMoments(matrix, result.mean, pool);
  // OpenCV's eigenvalues descend, and its eigenvectors are rows.
  cv::Mat energies;
  cv::Mat axes;
  if (!cv::eigen(cv::Mat(dim, dim, CV_64F, moments.data()), energies, axes)) {
    return InternalError("the axes of a covariance did not converge");
  }
  result.axes.resize(static_cast<size_t>(dim) * dim);
  for (int k = 0; k < dim; ++k) {
    result.energies.push_back(std::max(0.0, energies.at<double>(k)));
    const double* axis = axes.ptr<double>(k);
    const double* largest =
        std::max_element(axis, axis + dim, [](double a, double b) {
          return std::abs(a) < std::abs(b);
        });
    const double sign = *largest < 0 ? -1 : 1;
    for (int c = 0; c < dim; ++c) {
      result.axes[static_cast<size_t>(k) * dim + c] =
          static_cast<float>(sign * axis[c]);
    }
  }
  return result;
}

int AxesForEnergy(std::span<const double> energies,
                  int skipped,
                  double share,
                  int max_count) {
  const int count = static_cast<int>(energies.size());
  const int first = std::min(skipped, count);
  const double total =
      std::accumulate(energies.begin() + first, energies.end(), 0.0);
  double sum = 0;
  int needed = first;
  while (needed < count && sum < share * total) sum += energies[needed++];
  return std::clamp(needed, 1, std::max(1, std::min(max_count, count)));
}

std::vector<float> ProjectOntoAxes(const PrincipalAxes& axes,
                                   std::span<const float> rows,
                                   ThreadPool& pool) {
  const auto count = static_cast<int64_t>(rows.size()) / axes.dim;
  std::vector<float> result(static_cast<size_t>(count) * axes.count);
  const RowMatrix columns =
      ConstRows(axes.axes.data(), axes.count, axes.dim).transpose();
  const ConstRows basis(columns.data(), axes.dim, axes.count);
  const Eigen::Map<const Eigen::RowVectorXf> mean(axes.mean.data(), axes.dim);
  pool.ParallelFor(0, count, kRowBlock, [&](int64_t first, int64_t last, int) {
    const int64_t size = last - first;
    const ConstRows in(rows.data() + first * axes.dim, size, axes.dim);
    Multiply(in.rowwise() - mean,
             basis,
             Rows(result.data() + first * axes.count, size, axes.count));
  });
  return result;
}

std::vector<float> ExpandFromAxes(const PrincipalAxes& axes,
                                  std::span<const float> coordinates,
                                  ThreadPool& pool) {
  const auto count = static_cast<int64_t>(coordinates.size()) / axes.count;
  std::vector<float> result(static_cast<size_t>(count) * axes.dim);
  const ConstRows basis(axes.axes.data(), axes.count, axes.dim);
  const Eigen::Map<const Eigen::RowVectorXf> mean(axes.mean.data(), axes.dim);
  pool.ParallelFor(0, count, kRowBlock, [&](int64_t first, int64_t last, int) {
    const int64_t size = last - first;
    const ConstRows in(
        coordinates.data() + first * axes.count, size, axes.count);
    Rows out(result.data() + first * axes.dim, size, axes.dim);
    Multiply(in, basis, out);
    out.rowwise() += mean;
  });
  return result;
}

}  // namespace freegs::semantics
