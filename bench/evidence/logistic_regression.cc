// SPDX-License-Identifier: BSD-3-Clause

#include "bench/evidence/logistic_regression.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Cholesky>

namespace freegs::evidence {

Eigen::VectorXd FitLogistic(const Eigen::MatrixXd& columns,
                            std::span<const LabelledExample> examples,
                            const Eigen::VectorXd& ridge,
                            int newton_steps,
                            ThreadPool& pool) {
  // Sums in parts of a fixed size do not depend on the threads.
  constexpr int64_t kPart = 4096;
  const Eigen::Index n = columns.rows();
  const int64_t count = columns.cols();
  const int64_t parts = (count + kPart - 1) / kPart;
  std::vector<Eigen::VectorXd> gradients(parts);
  std::vector<Eigen::MatrixXd> hessians(parts);
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(n);
  for (int step = 0; step < newton_steps; ++step) {
    pool.ParallelFor(0, parts, 1, [&](int64_t first, int64_t last, int) {
      for (int64_t part = first; part < last; ++part) {
        const int64_t begin = part * kPart;
        const int64_t size = std::min(count - begin, kPart);
        const auto x = columns.middleCols(begin, size);
        Eigen::ArrayXd residuals = x.transpose() * weights;
        Eigen::ArrayXd curvature(size);
        for (int64_t i = 0; i < size; ++i) {
          const LabelledExample& example = examples[begin + i];
          const double p = 1 / (1 + std::exp(-residuals[i]));
          residuals[i] = example.weight * (p - (example.positive ? 1 : 0));
          curvature[i] = example.weight * p * (1 - p);
        }
        gradients[part] = x * residuals.matrix();
        hessians[part] = x * curvature.matrix().asDiagonal() * x.transpose();
      }
    });
    Eigen::VectorXd gradient = ridge.cwiseProduct(weights);
    Eigen::MatrixXd hessian = ridge.asDiagonal();
    for (int64_t part = 0; part < parts; ++part) {
      gradient += gradients[part];
      hessian += hessians[part];
    }
    weights -= hessian.ldlt().solve(gradient);
  }
  return weights;
}

}  // namespace freegs::evidence
