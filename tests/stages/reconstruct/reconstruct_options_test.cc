// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/reconstruct_options.h"

#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

TEST(ReconstructOptionsTest, OnlyLongTrainingsStartAgainFromDepthMaps) {
  for (const int iterations : {2500, 19999, 20000}) {
    ReconstructStageOptions options;
    options.iterations = iterations;
    const auto training =
        MakeTrainerOptions(options, int64_t{1} << 24, int64_t{1} << 33, 0);
    ASSERT_TRUE(training.ok()) << training.status().message();
    EXPECT_EQ(training->schedule.depth_reinit_at.empty(), iterations < 20000)
        << iterations;
  }
}

TEST(ReconstructOptionsTest, LongerTrainingsHaveSmallerRates) {
  const auto rates = [](int iterations) {
    ReconstructStageOptions options;
    options.iterations = iterations;
    return MakeTrainerOptions(options, int64_t{1} << 24, int64_t{1} << 33, 0)
        ->learning_rates;
  };
  const splat::LearningRateOptions original;
  EXPECT_EQ(rates(30000).mean_initial, original.mean_initial);
  EXPECT_EQ(rates(30000).opacity_logit, original.opacity_logit);
  // Presets balanced and quality.
  EXPECT_EQ(rates(5000).mean_initial, rates(2500).mean_initial);
  EXPECT_EQ(rates(5000).sh_dc, rates(2500).sh_dc);
  double last = 1;
  for (const int iterations : {500, 1500, 2500, 5000, 8000, 15000, 30000}) {
    EXPECT_LE(rates(iterations).log_scale, last) << iterations;
    last = rates(iterations).log_scale;
  }
}

TEST(ReconstructOptionsTest, TheCacheIsNoLargerThanCanBeCounted) {
  ReconstructStageOptions options;
  pipeline::OptionTable table;
  RegisterReconstructOptions(options, table);
  const auto apply = [&](const std::string& value) {
    return table.Apply({{"reconstruct.image_cache_gb", value, "test"}});
  };
  EXPECT_TRUE(apply("1e6").ok());
  EXPECT_EQ(apply("1e12").code(), StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace freegs::stages
