// SPDX-License-Identifier: BSD-3-Clause
// Logistic regression of weighted examples, with a ridge.

#ifndef FREEGS_BENCH_EVIDENCE_LOGISTIC_REGRESSION_H_
#define FREEGS_BENCH_EVIDENCE_LOGISTIC_REGRESSION_H_

#include <span>

#include <Eigen/Core>

#include "core/parallel.h"

namespace freegs::evidence {

struct LabelledExample {
  bool positive = false;
  double weight = 1;
};

// The weights w that make least
//
//   sum_i weight_i log(1 + exp(-s_i w.x_i)) + sum_k ridge_k w_k^2 / 2,
//
// where s_i is 1 for positive examples and -1 for others, by `newton_steps`
// steps of Newton's method from 0. `columns` has x_i in column i, and as many
// columns as there are examples. A positive ridge for each weight makes the
// steps well-defined. The result does not depend on the threads of `pool`.
Eigen::VectorXd FitLogistic(const Eigen::MatrixXd& columns,
                            std::span<const LabelledExample> examples,
                            const Eigen::VectorXd& ridge,
                            int newton_steps,
                            ThreadPool& pool);

}  // namespace freegs::evidence

#endif  // FREEGS_BENCH_EVIDENCE_LOGISTIC_REGRESSION_H_
