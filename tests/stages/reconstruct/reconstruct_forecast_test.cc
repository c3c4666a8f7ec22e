// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/reconstruct_memory.h"

#include <gtest/gtest.h>

#include "pipeline/stage.h"

namespace freegs::stages {
namespace {

constexpr int64_t kMillion = 1'000'000;

ReconstructSize SomeSize() {
  return {.train_pixels = 20 * kMillion,
          .holdout_pixels = 3 * kMillion,
          .view_pixels = kMillion,
          .photo_pixels = 2 * kMillion,
          .points = 10000,
          .threads = 2};
}

splat::TrainerOptions Training(const ReconstructStageOptions& options,
                               const ReconstructSize& size) {
  return *MakeTrainerOptions(
      options, size.train_pixels, int64_t{16} * 1000 * kMillion, 0);
}

int64_t Memory(const ReconstructStageOptions& options,
               const ReconstructSize& size) {
  return ReconstructMemory(options, Training(options, size), size);
}

TEST(ReconstructMemoryTest, GrowsWithTheScene) {
  const ReconstructStageOptions options;
  const int64_t some = Memory(options, SomeSize());
  EXPECT_GT(some, pipeline::kProgramMemory);
  for (int64_t ReconstructSize::*part : {&ReconstructSize::train_pixels,
                                         &ReconstructSize::holdout_pixels,
                                         &ReconstructSize::view_pixels}) {
    ReconstructSize more = SomeSize();
    more.*part *= 2;
    EXPECT_GT(Memory(options, more), some);
  }
  ReconstructSize photos = SomeSize();
  photos.photo_pixels = 100 * kMillion;
  const int64_t large = Memory(options, photos);
  EXPECT_GT(large, some);
  photos.threads = 8;
  EXPECT_GT(Memory(options, photos), large);
}

TEST(ReconstructMemoryTest, PhotosBeyondTheCacheTakeNone) {
  ReconstructStageOptions options;
  options.budget = "50000";
  ReconstructSize size = SomeSize();
  const int64_t all = Memory(options, size);
  options.image_cache_gb = 0.02;
  const int64_t some = Memory(options, size);
  EXPECT_EQ(all - some, 80 * kMillion - 20 * kMillion);
  size.train_pixels *= 10;
  EXPECT_EQ(Memory(options, size), some);
}

TEST(ReconstructMemoryTest, GaussiansGrowFromThePointsUpToTheBudget) {
  ReconstructStageOptions options;
  options.budget = "50000";
  options.iterations = 5000;
  options.densify_interval = 100;
  ReconstructSize size = SomeSize();
  const auto expected = [&] {
    return *ExpectedGaussians(options, Training(options, size), size);
  };
  // Mini-Splatting has twice the budget before it simplifies.
  EXPECT_EQ(expected(), 100000);
  options.densification = "gradient";
  EXPECT_EQ(expected(), 50000);
  options.densification = "none";
  EXPECT_EQ(expected(), 10000);
  options.densification = "mini_splatting";
  options.iterations = 600;  // Densified at 100 and 200.
  EXPECT_NEAR(expected(), 19600, 1e-6);
  size.points = 200000;  // More than the budget, to begin with.
  EXPECT_EQ(expected(), 200000);
}

TEST(ReconstructMemoryTest, MasksTakeAByteAPixel) {
  const ReconstructStageOptions options;
  ReconstructSize size = SomeSize();
  const int64_t without = Memory(options, size);
  size.masks = true;
  EXPECT_NEAR(
      Memory(options, size) - without, 20e6 * 4 / 3 + 3e6 * 21 / 16, 2.0);
}

TEST(AutomaticBudgetTest, FollowsPhotosAndMemory) {
  const int64_t large = int64_t{64} * 1000 * kMillion;
  EXPECT_EQ(AutomaticBudget(15 * kMillion, large), 200000);
  EXPECT_EQ(AutomaticBudget(30 * kMillion, large), 400000);
  EXPECT_EQ(AutomaticBudget(300 * kMillion, large), 400000);
  // Ten small photos.
  EXPECT_EQ(AutomaticBudget(3 * kMillion, large), 40000);
  EXPECT_EQ(AutomaticBudget(1000, large), 5000);
  // A machine with half a gigabyte.
  const int64_t small = AutomaticBudget(300 * kMillion, 500 * kMillion);
  EXPECT_GT(small, 100000);
  EXPECT_LT(small, 200000);
  // A number given is taken as it is.
  ReconstructStageOptions options;
  options.budget = "123";
  EXPECT_EQ(Training(options, SomeSize()).budget, 123);
}

TEST(ReconstructMemoryTest, ALowerShDegreeTakesLess) {
  ReconstructStageOptions options;
  const int64_t most = Memory(options, SomeSize());
  options.sh_degree = 0;
  EXPECT_LT(Memory(options, SomeSize()), most);
}

TEST(ReconstructMemoryTest, NothingIsKnownWithoutABudget) {
  ReconstructStageOptions options;
  options.budget = "0";
  EXPECT_EQ(Memory(options, SomeSize()), 0);
  options.densification = "none";
  EXPECT_GT(Memory(options, SomeSize()), 0);
}

TEST(ReconstructMemoryTest, AnImportedModelIsNotTrained) {
  ReconstructStageOptions options;
  options.budget = "0";
  options.import = "scene.ply";
  ReconstructSize size = SomeSize();
  size.imported_gaussians = 1000;
  const int64_t small = Memory(options, size);
  EXPECT_GT(small, pipeline::kProgramMemory);
  size.imported_gaussians = kMillion;
  EXPECT_GT(Memory(options, size), small + 500 * kMillion);
}

}  // namespace
}  // namespace freegs::stages
