// SPDX-License-Identifier: BSD-3-Clause

#include "bench/evidence/calibration.h"

#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace freegs::evidence {
namespace {

double LogLikelihood(const std::vector<JudgedMerge>& merges,
                     double slope,
                     double offset) {
  double sum = 0;
  for (const JudgedMerge& merge : merges) {
    const double z = slope * merge.height + offset;
    sum -= std::log1p(std::exp(merge.different ? -z : z));
  }
  return sum;
}

std::vector<JudgedMerge> Overstated() {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<JudgedMerge> merges;
  for (int i = 0; i < 20000; ++i) {
    const double height = 10 * uniform(random) - 5;
    const double p = 1 / (1 + std::exp(-0.6 * height + 0.3));
    merges.push_back({height, uniform(random) < p});
  }
  return merges;
}

TEST(CalibrationTest, FindsByHowMuchOddsAreOverstated) {
  const Calibration fit = FitCalibration(Overstated());
  EXPECT_NEAR(fit.slope, 0.6, 0.03);
  EXPECT_NEAR(fit.offset, -0.3, 0.05);
}

// Central differences of the formula vanish where Newton's method ends.
TEST(CalibrationTest, NothingNearIsMoreLikely) {
  const std::vector<JudgedMerge> merges = Overstated();
  const Calibration fit = FitCalibration(merges);
  constexpr double kStep = 1e-3;
  const double by_slope =
      (LogLikelihood(merges, fit.slope + kStep, fit.offset) -
       LogLikelihood(merges, fit.slope - kStep, fit.offset)) /
      (2 * kStep);
  const double by_offset =
      (LogLikelihood(merges, fit.slope, fit.offset + kStep) -
       LogLikelihood(merges, fit.slope, fit.offset - kStep)) /
      (2 * kStep);
  const double size = static_cast<double>(merges.size());
  EXPECT_NEAR(by_slope / size, 0, 1e-5);
  EXPECT_NEAR(by_offset / size, 0, 1e-5);
}

TEST(CalibrationTest, WithoutBothKindsNothingChanges) {
  for (const std::vector<JudgedMerge>& merges :
       {std::vector<JudgedMerge>{},
        std::vector<JudgedMerge>{{1, true}, {2, true}},
        std::vector<JudgedMerge>{{1, true}, {2, false}}}) {
    const Calibration fit = FitCalibration(merges);
    EXPECT_EQ(fit.slope, 1);
    EXPECT_EQ(fit.offset, 0);
  }
}

TEST(CalibrationTest, DifferencesOfTheModelAreCalibrated) {
  semantics::EvidenceModel model;
  model.bias = -2;
  semantics::Evidence evidence = {};
  for (size_t k = 0; k < semantics::kNumEvidences; ++k) {
    model.mean[k] = 0.1 * static_cast<double>(k);
    model.deviation[k] = 1 + 0.2 * static_cast<double>(k);
    model.weight[k] = 0.5 - 0.1 * static_cast<double>(k);
    evidence[k] = 0.3f;
  }
  const double before = model.Difference(evidence);
  EXPECT_NEAR(Calibrated(model, {0.7, -0.2}).Difference(evidence),
              0.7 * before - 0.2,
              1e-12);
}

// Segments 1 = {0, 1} and 2 = {2}; patch 3 is too small to count.
TEST(CalibrationTest, MergesAreJudgedByTheTruth) {
  LearningScene scene;
  scene.patches.graph.regions.resize(4);
  scene.patches.graph.total_pixels = 3000;
  scene.pixels = {1000, 1000, 999, 1};
  scene.votes = {{{1, 1000.0}}, {{1, 900.0}, {2, 100.0}}, {{2, 999.0}}, {}};
  for (size_t i = 0; i < 4; ++i) {
    scene.patches.graph.regions[i].pixels = scene.pixels[i];
  }
  const float steps[] = {0.1f, 0.8f, 0.4f};
  for (int i = 0; i < 3; ++i) {
    semantics::ContactStats contact;
    contact.pixels = 10;
    contact.contrast_near = 10 * steps[i];
    scene.patches.graph.contacts.push_back({i, i + 1, contact});
  }
  semantics::EvidenceModel model;
  model.deviation.fill(1);
  model.weight[semantics::kContrastNear] = 1;
  const std::vector<JudgedMerge> merges = JudgeMerges(scene, model);
  ASSERT_EQ(merges.size(), 2u);
  EXPECT_NEAR(merges[0].height, 0.1, 1e-6);
  EXPECT_FALSE(merges[0].different);
  EXPECT_NEAR(merges[1].height, 0.8, 1e-6);
  EXPECT_TRUE(merges[1].different);
}

}  // namespace
}  // namespace freegs::evidence
