// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bootstrap/bootstrap_memory.h"

#include <gtest/gtest.h>

#include "pipeline/stage.h"

namespace freegs::stages {
namespace {

BootstrapSize SomeSize() {
  return {.weight_pixels = 24 * 224 * 168,
          .patch_pixels = 400 * 300,
          .photo_pixels = 2'000'000,
          .gaussians = 50000,
          .model_bytes = 12'000'000,
          .threads = 2};
}

TEST(BootstrapMemoryTest, GrowsWithTheScene) {
  const int64_t some = BootstrapMemory({}, SomeSize());
  EXPECT_GT(some, pipeline::kProgramMemory);
  for (int64_t BootstrapSize::*part : {&BootstrapSize::weight_pixels,
                                       &BootstrapSize::patch_pixels,
                                       &BootstrapSize::photo_pixels,
                                       &BootstrapSize::gaussians,
                                       &BootstrapSize::model_bytes}) {
    BootstrapSize more = SomeSize();
    more.*part *= 2;
    EXPECT_GT(BootstrapMemory({}, more), some);
  }
  BootstrapSize more = SomeSize();
  more.threads = 4;
  EXPECT_GT(BootstrapMemory({}, more), some);
}

TEST(BootstrapMemoryTest, WeightsKeepToTheirLimit) {
  BootstrapStageOptions options;
  const int64_t all = BootstrapMemory(options, SomeSize());
  options.weights_memory_gb = 0.1;
  const int64_t some = BootstrapMemory(options, SomeSize());
  EXPECT_LT(some, all);
  BootstrapSize more = SomeSize();
  more.weight_pixels *= 100;
  EXPECT_EQ(BootstrapMemory(options, more), some);
}

TEST(BootstrapMemoryTest, ModesTakeMoreAndLess) {
  BootstrapStageOptions options;
  const int64_t lift = BootstrapMemory(options, SomeSize());
  options.mode = "paper";
  EXPECT_GT(BootstrapMemory(options, SomeSize()), lift);
  options.mode = "geometry";
  EXPECT_LT(BootstrapMemory(options, SomeSize()), lift);
}

}  // namespace
}  // namespace freegs::stages
