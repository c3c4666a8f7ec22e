// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/label_noise.h"

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

TEST(LabelNoiseTest, NoiseTakesTheNearestLabelWithinReach) {
  const std::vector<float> positions = {
      0, 0, 0, 1, 0, 0, 0.4f, 0, 0, 1.15f, 0, 0, 5, 0, 0};
  std::vector<int32_t> labels = {2, 1, -1, -1, -1};
  ThreadPool pool(2);
  LabelNoise(positions, 0.5, pool, &labels);
  EXPECT_EQ(labels, (std::vector<int32_t>{2, 1, 2, 1, -1}));
}

TEST(LabelNoiseTest, NothingLabelled) {
  std::vector<int32_t> labels(3, -1);
  const std::vector<float> positions(9, 0.0f);
  ThreadPool pool(1);
  LabelNoise(positions, 1, pool, &labels);
  EXPECT_EQ(labels, std::vector<int32_t>(3, -1));
  std::vector<int32_t> none;
  LabelNoise(std::vector<float>(), 1, pool, &none);
  EXPECT_TRUE(none.empty());
}

}  // namespace
}  // namespace freegs::semantics
