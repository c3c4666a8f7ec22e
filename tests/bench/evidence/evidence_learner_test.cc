// SPDX-License-Identifier: BSD-3-Clause

#include "bench/evidence/evidence_learner.h"

#include <cmath>
#include <random>
#include <vector>

#include <gmock/gmock.h>
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

TEST(EvidenceLearnerTest, NamesOfNoEvidenceAreRefused) {
  EXPECT_TRUE(CheckEvidenceNames({}).ok());
  EXPECT_TRUE(CheckEvidenceNames({"color", "size"}).ok());
  const Status status = CheckEvidenceNames({"color", "colour"});
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), testing::HasSubstr("\"colour\""));
  EXPECT_THAT(status.message(), testing::HasSubstr("color_contrast"));
}

// Three patches in a row, of which the first `known` are of one thing each.
LearningScene RowOfPatches(int known) {
  LearningScene scene;
  scene.patches.graph.regions.resize(3);
  scene.patches.graph.total_pixels = 3000;
  scene.pixels = {1000, 1000, 1000};
  scene.votes.resize(3);
  for (int i = 0; i < known; ++i) scene.votes[i][i / 2 + 1] = 1000;
  for (int i = 0; i < 3; ++i) scene.patches.graph.regions[i].pixels = 1000;
  for (int i = 0; i < 2; ++i) {
    semantics::ContactStats contact;
    contact.pixels = 10;
    contact.contrast_near = i;
    scene.patches.graph.contacts.push_back({i, i + 1, contact});
  }
  return scene;
}

TEST(EvidenceLearnerTest, NothingIsLearntFromNothing) {
  ThreadPool pool(1);
  const LearningScene unknown = RowOfPatches(0);
  const auto none = LearnEvidence({&unknown, 1}, {}, pool);
  EXPECT_EQ(none.status().code(), StatusCode::kBadInput);
  // One scene of two that tells something is enough.
  const std::vector<LearningScene> scenes = {unknown, RowOfPatches(3)};
  const auto learnt = LearnEvidence(scenes, {}, pool);
  ASSERT_TRUE(learnt.ok()) << learnt.status().message();
  EXPECT_GT(learnt->num_examples, 0u);
  for (size_t k = 0; k < semantics::kNumEvidences; ++k) {
    EXPECT_TRUE(std::isfinite(learnt->model.mean[k])) << k;
    EXPECT_TRUE(std::isfinite(learnt->model.weight[k])) << k;
  }
  EXPECT_TRUE(std::isfinite(learnt->model.bias));
}

}  // namespace
}  // namespace freegs::evidence
