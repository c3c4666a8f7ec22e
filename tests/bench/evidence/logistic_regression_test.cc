// SPDX-License-Identifier: BSD-3-Clause
// The weights make the loss least, and do not depend on threads.

#include "bench/evidence/logistic_regression.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::evidence {
namespace {

class FitLogisticTest : public testing::Test {
 protected:
  FitLogisticTest() {
    RandomStream random(3, 1);
    for (int i = 0; i < columns_.cols(); ++i) {
      for (int k = 0; k < 3; ++k) columns_(k, i) = random.Normal();
      columns_(3, i) = 1;
      const double odds = columns_(0, i) - 2 * columns_(1, i) + 0.5;
      examples_.push_back({random.Normal() < odds, 0.5 + random.Uniform()});
    }
  }

  double Loss(const Eigen::VectorXd& weights) const {
    double loss = 0.5 * ridge_.dot(weights.cwiseAbs2());
    for (size_t i = 0; i < examples_.size(); ++i) {
      const double odds =
          weights.dot(columns_.col(static_cast<Eigen::Index>(i)));
      const double sign = examples_[i].positive ? 1 : -1;
      loss += examples_[i].weight * std::log1p(std::exp(-sign * odds));
    }
    return loss;
  }

  // More than one part of the sums.
  Eigen::MatrixXd columns_ = Eigen::MatrixXd(4, 5000);
  std::vector<LabelledExample> examples_;
  Eigen::VectorXd ridge_ = Eigen::Vector4d(1, 2, 300, 0.1);
};

TEST_F(FitLogisticTest, MakesTheLossLeast) {
  ThreadPool pool(2);
  const Eigen::VectorXd weights =
      FitLogistic(columns_, examples_, ridge_, 15, pool);
  constexpr double kStep = 1e-4;
  for (int k = 0; k < 4; ++k) {
    Eigen::VectorXd more = weights;
    Eigen::VectorXd less = weights;
    more[k] += kStep;
    less[k] -= kStep;
    EXPECT_NEAR((Loss(more) - Loss(less)) / (2 * kStep), 0, 1e-4) << k;
    EXPECT_GT(Loss(more), Loss(weights));
  }
  EXPECT_GT(weights[0], 0.5);
  EXPECT_LT(weights[1], -1);
}

TEST_F(FitLogisticTest, SameForAnyNumberOfThreads) {
  ThreadPool one(1);
  ThreadPool three(3);
  EXPECT_EQ(FitLogistic(columns_, examples_, ridge_, 5, one),
            FitLogistic(columns_, examples_, ridge_, 5, three));
}

}  // namespace
}  // namespace freegs::evidence
