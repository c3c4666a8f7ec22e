// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/scene_instances.h"

#include <gtest/gtest.h>

#include "semantics/instances/palette.h"
#include "tests/stages/synthetic_workspace.h"

namespace freegs::stages {
namespace {

TEST(SceneInstancesTest, ReadsLabels) {
  SyntheticWorkspace workspace;
  EXPECT_EQ(ReadInstanceLabels(workspace.path(), 120).status().code(),
            StatusCode::kBadInput);
  workspace.AddInstances();
  const auto labels = ReadInstanceLabels(workspace.path(), 120);
  ASSERT_TRUE(labels.ok());
  EXPECT_EQ(*labels, workspace.labels);
  EXPECT_EQ(ReadInstanceLabels(workspace.path(), 119).status().code(),
            StatusCode::kBadInput);
}

TEST(SceneInstancesTest, Pictures) {
  Image<int32_t> labels(4, 1, 1);
  labels(0, 0) = -1;
  labels(1, 0) = 5;
  labels(2, 0) = 5;
  labels(3, 0) = 70000;
  const ImageU16 ids = EncodeInstances(labels);
  EXPECT_EQ(ids(0, 0), 0);
  EXPECT_EQ(ids(1, 0), 6);
  EXPECT_EQ(ids(3, 0), 0);
  const ImageU8 mask = InstanceMask(labels, 5);
  EXPECT_EQ(mask(0, 0), 0);
  EXPECT_EQ(mask(2, 0), 255);
  const ImageU8 colors = ColorInstances(labels);
  const auto color = semantics::PaletteColor(5);
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(colors(1, 0, c), color[static_cast<size_t>(c)]);
  }

  const ImageU8 photo(4, 1, 3, 200);
  const ImageU8 overlay = OverlayInstances(photo, labels);
  for (int c = 0; c < 3; ++c) {
    // A line at the last pixel before another label.
    EXPECT_GT(overlay(0, 0, c), 240);
    EXPECT_NEAR(
        overlay(1, 0, c), 0.4 * 200 + 0.6 * color[static_cast<size_t>(c)], 1);
    EXPECT_GT(overlay(2, 0, c), 240);
  }
  labels = Image<int32_t>(4, 1, 1, -1);
  EXPECT_LT(OverlayInstances(photo, labels)(1, 0, 0), 100);
}

}  // namespace
}  // namespace freegs::stages
