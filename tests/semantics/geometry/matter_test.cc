// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/geometry/matter.h"

#include <limits>

#include <gtest/gtest.h>

#include "tests/semantics/synthetic_gaussians.h"

namespace freegs::semantics {
namespace {

TEST(MatterTest, LeavesOutHazeBackdropAndWhatIsNowhere) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  SyntheticGaussians scene;
  scene.Add({1, 2, 3}, {0.25, 0.5, 0.75}, 0.1, 0.9, 0);
  scene.Add({0, 0, 0}, {0, 0, 0}, 0.1, 0.05, 0);  // Faint.
  scene.Add({0, 0, 0}, {0, 0, 0}, 0.5, 0.9, 0);   // Large.
  scene.Add({nan, 0, 0}, {0, 0, 0}, 0.1, 0.9, 0);
  scene.Add({0, inf, 0}, {0, 0, 0}, 0.1, 0.9, 0);
  scene.Add({0, 0, 1e20}, {0, 0, 0}, 0.1, 0.9, 0);
  scene.Add({0, 0, 0}, {0, 0, 0}, 0.1, 0.9, 0);  // Broken below.
  scene.model.opacity_logits.back() = nan;
  scene.Add({0, 0, 0}, {0, 0, 0}, 0.1, 0.9, 0);  // Long but thin.
  scene.model.log_scales[scene.model.log_scales.size() - 3] = 2;
  scene.Add({4, 5, 6}, {2, -1, 0.5}, 0.1, 0.9, 0);  // Colours out of range.
  const Matter matter = SelectMatter(scene.model, 0.1, 0.2);
  EXPECT_EQ(matter.rows, (std::vector<uint32_t>{0, 7, 8}));
  ASSERT_EQ(matter.positions.size(), 9u);
  EXPECT_EQ(matter.positions[1], 2);
  EXPECT_EQ(matter.positions[8], 6);
  ASSERT_EQ(matter.colors.size(), 9u);
  EXPECT_NEAR(matter.colors[0], 0.25, 1e-6);
  EXPECT_NEAR(matter.colors[2], 0.75, 1e-6);
  EXPECT_EQ(matter.colors[6], 1);
  EXPECT_EQ(matter.colors[7], 0);
}

TEST(MatterTest, OfNothing) {
  EXPECT_TRUE(SelectMatter(splat::GaussianModel(), 0.1, 1).rows.empty());
}

}  // namespace
}  // namespace freegs::semantics
