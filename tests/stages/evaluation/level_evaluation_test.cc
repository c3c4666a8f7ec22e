// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation/level_evaluation.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/stages/ball_scene.h"

namespace freegs::stages {
namespace {

class LevelEvaluationTest : public BallScene {
 protected:
  // Each ball consists of two parts, 2 k and 2 k + 1; regions 6, 7, 8 are the
  // balls, 9 is the first two of them.
  semantics::Hierarchy Halves() const {
    semantics::Hierarchy hierarchy;
    hierarchy.tree.num_leaves = 6;
    hierarchy.tree.merges = {{0, 1, -2}, {2, 3, -2}, {4, 5, -2}, {6, 7, 1}};
    hierarchy.quality = {0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.9, 0.9, 0.9, 0.5};
    hierarchy.part_pixels.assign(6, 1000);
    hierarchy.total_pixels = 6000;
    for (size_t g = 0; g < labels_.size(); ++g) {
      const int half = static_cast<int>(g % 2);
      hierarchy.part_of_gaussian.push_back(
          labels_[g] < 0 || labels_[g] > 2 ? -1 : 2 * labels_[g] + half);
    }
    return hierarchy;
  }

  double BestLevels(const std::vector<int32_t>& labels,
                    const semantics::Hierarchy& hierarchy) {
    const auto measured =
        MeasureBestLevels(Context(MakeScene()), labels, hierarchy);
    EXPECT_TRUE(measured.ok() && measured->has_value());
    return measured.ok() ? measured->value_or(-1) : -1;
  }
};

TEST_F(LevelEvaluationTest, ARegionIsFoundWhereTheCutIsTooCoarse) {
  std::vector<int32_t> merged = labels_;
  for (int32_t& label : merged) label = std::min(label, 1);
  EXPECT_GT(BestLevels(merged, Halves()), 0.97);
}

TEST_F(LevelEvaluationTest, ARegionIsFoundWhereTheCutIsTooFine) {
  EXPECT_GT(BestLevels(Halves().part_of_gaussian, Halves()), 0.97);
}

TEST_F(LevelEvaluationTest, TheInstanceIsTakenWhereNoRegionIsAsGood) {
  semantics::Hierarchy hierarchy = Halves();
  // A tree of parts that mix the balls.
  for (size_t g = 0; g < hierarchy.part_of_gaussian.size(); ++g) {
    hierarchy.part_of_gaussian[g] = static_cast<int32_t>(g % 6);
  }
  EXPECT_GT(BestLevels(labels_, hierarchy), 0.97);
}

TEST_F(LevelEvaluationTest, NothingIsMeasuredWithoutMasks) {
  truth_.masks.clear();
  const auto measured =
      MeasureBestLevels(Context(MakeScene()), labels_, Halves());
  ASSERT_TRUE(measured.ok());
  EXPECT_FALSE(measured->has_value());
}

}  // namespace
}  // namespace freegs::stages
