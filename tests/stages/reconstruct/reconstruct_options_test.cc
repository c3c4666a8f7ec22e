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

}  // namespace
}  // namespace freegs::stages
