// SPDX-License-Identifier: BSD-3-Clause

#include "splat/train/stability.h"

#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "tests/splat/random_model.h"

namespace freegs::splat {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

std::vector<uint32_t> All(const GaussianModel& model) {
  std::vector<uint32_t> all(model.size());
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

TEST(BoundParameters, LeavesSoundGaussiansAlone) {
  const GaussianModel before = RandomModel(10000, 1, 3);
  GaussianModel model = before;
  EXPECT_TRUE(BoundParameters(2.0, All(model), &model));
  EXPECT_TRUE(SameParameters(model, before));
}

TEST(BoundParameters, BringsBackTouchedOnes) {
  GaussianModel model = RandomModel(3, 0, 3);
  model.log_scales = {-99, 99, 0, -99, 99, 0, 0, 0, 0};
  model.opacity_logits = {99, 99, -99};
  model.rotations = {100, 0, 0, 0, 0, 0, 0, 0, 0, 3e-30f, 4e-30f, 0};
  EXPECT_TRUE(BoundParameters(2.0, std::vector<uint32_t>{0, 2}, &model));
  EXPECT_FLOAT_EQ(model.log_scales[0], std::log(2e-7f));
  EXPECT_FLOAT_EQ(model.log_scales[1], std::log(200.0f));
  EXPECT_EQ(model.log_scales[2], 0);
  EXPECT_EQ(model.log_scales[3], -99);  // Not touched.
  EXPECT_EQ(model.opacity_logits, std::vector<float>({15, 99, -15}));
  EXPECT_FLOAT_EQ(model.rotations[0], 1);
  EXPECT_EQ(model.rotations[4], 0);  // Not touched.
  EXPECT_FLOAT_EQ(model.rotations[9], 0.6f);
  EXPECT_FLOAT_EQ(model.rotations[10], 0.8f);
  EXPECT_TRUE(BoundParameters(2.0, All(model), &model));
  EXPECT_EQ(model.rotations[4], 1);  // No direction at all.
}

TEST(BoundParameters, TellsOfNumbersThatAreNotFinite) {
  for (const float bad : {kNan, kInfinity, -kInfinity}) {
    for (const Parameter parameter : {Parameter::kMean,
                                      Parameter::kLogScale,
                                      Parameter::kRotation,
                                      Parameter::kOpacityLogit}) {
      GaussianModel model = RandomModel(5, 0, 3);
      ParameterArray(model, parameter)[2 * ParameterStride(model, parameter)] =
          bad;
      const std::vector<uint32_t> others = {0, 1, 3, 4};
      EXPECT_TRUE(BoundParameters(1.0, others, &model));
      EXPECT_FALSE(BoundParameters(1.0, All(model), &model));
    }
  }
}

TEST(LossMonitor, AcceptsWhatTrainingLooksLike) {
  LossMonitor monitor(30);
  for (int k = 0; k < 2000; ++k) {
    // Views of different difficulty, and a loss that falls.
    const double loss = 0.02 + 0.4 * std::exp(-k / 200.0) + 0.15 * (k % 3 == 0);
    EXPECT_FALSE(monitor.Add(loss).has_value()) << k;
    EXPECT_TRUE(monitor.Healthy()) << k;
  }
}

TEST(LossMonitor, FindsExplosions) {
  LossMonitor monitor(30);
  EXPECT_TRUE(monitor.Add(NAN).has_value());
  EXPECT_TRUE(monitor.Add(INFINITY).has_value());
  for (int k = 0; k < 100; ++k) ASSERT_FALSE(monitor.Add(0.05).has_value());
  int steps = 0;
  bool was_unhealthy_before = false;
  while (!monitor.Add(0.9).has_value()) {
    was_unhealthy_before = was_unhealthy_before || !monitor.Healthy();
    ASSERT_LT(++steps, 60);
  }
  EXPECT_TRUE(was_unhealthy_before);
  monitor.Reset();
  for (int k = 0; k < 100; ++k) ASSERT_FALSE(monitor.Add(0.9).has_value());
}

TEST(LossMonitor, FindsSenselessLossesAtOnce) {
  LossMonitor monitor(30);
  int steps = 1;
  while (!monitor.Add(40).has_value()) ++steps;
  EXPECT_EQ(steps, 5);
}

TEST(LossMonitor, StateGoesOn) {
  LossMonitor a(30);
  for (int k = 0; k < 50; ++k) ASSERT_FALSE(a.Add(0.1).has_value());
  LossMonitor b(30);
  b.set_state(a.state());
  for (int k = 0; k < 50; ++k) {
    EXPECT_EQ(a.Add(0.01 * k).has_value(), b.Add(0.01 * k).has_value());
    EXPECT_EQ(a.state(), b.state());
  }
}

}  // namespace
}  // namespace freegs::splat
