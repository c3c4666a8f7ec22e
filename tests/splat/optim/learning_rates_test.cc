// SPDX-License-Identifier: BSD-3-Clause

#include "splat/optim/learning_rates.h"

#include <cmath>

#include <gtest/gtest.h>

namespace freegs::splat {
namespace {

float Rate(const LearningRates& rates, Parameter parameter) {
  return rates[static_cast<int>(parameter)];
}

TEST(LearningRatesTest, PositionDecaysExponentiallyWithTheExtent) {
  const LearningRateOptions options;
  const auto mean = [&](double extent, double iteration) {
    return Rate(LearningRatesAt(options, extent, iteration), Parameter::kMean);
  };
  EXPECT_FLOAT_EQ(mean(1, 0), 1.6e-4f);
  EXPECT_FLOAT_EQ(mean(5, 0), 8e-4f);
  EXPECT_FLOAT_EQ(mean(1, 15000), 1.6e-5f);
  EXPECT_FLOAT_EQ(mean(1, 30000), 1.6e-6f);
  EXPECT_FLOAT_EQ(mean(1, 90000), 1.6e-6f);
}

TEST(LearningRatesTest, OthersStay) {
  const LearningRateOptions options;
  for (const double iteration : {0.0, 123.0, 1e6}) {
    const LearningRates rates = LearningRatesAt(options, 7, iteration);
    EXPECT_EQ(Rate(rates, Parameter::kShDc), 2.5e-3f);
    EXPECT_EQ(Rate(rates, Parameter::kShRest), 1.25e-4f);
    EXPECT_EQ(Rate(rates, Parameter::kOpacityLogit), 0.05f);
    EXPECT_EQ(Rate(rates, Parameter::kLogScale), 5e-3f);
    EXPECT_EQ(Rate(rates, Parameter::kRotation), 1e-3f);
  }
}

TEST(LearningRatesTest, OptionsAreChecked) {
  EXPECT_TRUE(LearningRateOptions().Check().ok());
  EXPECT_FALSE(LearningRateOptions{.mean_initial = 0}.Check().ok());
  EXPECT_FALSE(LearningRateOptions{.mean_decay_steps = 0}.Check().ok());
  EXPECT_FALSE(LearningRateOptions{.rotation = NAN}.Check().ok());
}

}  // namespace
}  // namespace freegs::splat
