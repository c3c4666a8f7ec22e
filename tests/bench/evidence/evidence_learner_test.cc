// SPDX-License-Identifier: BSD-3-Clause

#include "bench/evidence/evidence_learner.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace freegs::evidence {
namespace {

std::vector<Example> Examples() {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<Example> examples;
  for (int i = 0; i < 3000; ++i) {
    Example example;
    for (float& value : example.evidence) value = uniform(random);
    const double z = 4 * example.evidence[semantics::kColor] -
                     3 * example.evidence[semantics::kSize] - 0.5;
    example.different = uniform(random) < 1 / (1 + std::exp(-z));
    example.weight = 0.5 + uniform(random);
    examples.push_back(example);
  }
  return examples;
}

// What FitEvidence makes least: log loss and half the squares of all weights.
double Loss(const std::vector<Example>& examples,
            const semantics::EvidenceModel& model) {
  double loss = model.bias * model.bias / 2;
  for (const double weight : model.weight) loss += weight * weight / 2;
  for (const Example& example : examples) {
    const double z = model.Difference(example.evidence);
    loss += example.weight * std::log1p(std::exp(example.different ? -z : z));
  }
  return loss;
}

TEST(EvidenceLearnerTest, NothingNearFitsBetter) {
  ThreadPool pool(2);
  const std::vector<Example> examples = Examples();
  const semantics::EvidenceModel fit = FitEvidence(examples, {}, pool);
  EXPECT_GT(fit.weight[semantics::kColor], 0.8);
  EXPECT_LT(fit.weight[semantics::kSize], -0.5);
  constexpr double kStep = 1e-3;
  for (size_t k = 0; k <= semantics::kNumEvidences; ++k) {
    const auto moved = [&](double by) {
      semantics::EvidenceModel model = fit;
      (k < semantics::kNumEvidences ? model.weight[k] : model.bias) += by;
      return Loss(examples, model);
    };
    EXPECT_NEAR((moved(kStep) - moved(-kStep)) / (2 * kStep), 0, 1e-3) << k;
  }
}

TEST(EvidenceLearnerTest, WhatIsLeftOutGetsNoWeight) {
  ThreadPool pool(1);
  const semantics::EvidenceModel fit = FitEvidence(Examples(), {"color"}, pool);
  EXPECT_EQ(fit.weight[semantics::kColor], 0);
}

}  // namespace
}  // namespace freegs::evidence
