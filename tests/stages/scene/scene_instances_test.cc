// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/scene_instances.h"

#include <cstdint>
#include <filesystem>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "core/io/files.h"
#include "pipeline/stage_record.h"
#include "semantics/instances/palette.h"
#include "splat/scene/ply_io.h"
#include "tests/stages/synthetic_workspace.h"

namespace freegs::stages {
namespace {

// A row of four pixels: of nothing, twice of instance 5, and of a label that is
// too large for a picture.
Image<int32_t> RowOfLabels() {
  Image<int32_t> labels(4, 1, 1);
  labels(0, 0) = -1;
  labels(1, 0) = 5;
  labels(2, 0) = 5;
  labels(3, 0) = 70000;
  return labels;
}

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

TEST(SceneInstancesTest, RefusesThoseOfAnotherModelOfTheSameSize) {
  SyntheticWorkspace workspace;
  workspace.AddInstances();
  workspace.AddHierarchy();
  const std::filesystem::path model =
      workspace / "reconstruct" / "point_cloud.ply";
  pipeline::StageRecord record;
  record.fingerprint.stage = "bootstrap";
  const auto write_record = [&] {
    return pipeline::WriteStageRecord(workspace / "bootstrap", record);
  };
  // A record without this input comes from elsewhere.
  ASSERT_TRUE(write_record().ok());
  EXPECT_TRUE(ReadInstanceLabels(workspace.path(), 120).ok());
  record.fingerprint.inputs["reconstruct/point_cloud.ply"] = {
      .hash = *HashFile(model), .files = 1};
  ASSERT_TRUE(write_record().ok());
  EXPECT_TRUE(ReadInstanceLabels(workspace.path(), 120).ok());
  EXPECT_TRUE(ReadSceneHierarchy(workspace.path(), 120).ok());

  std::vector<uint32_t> backwards(workspace.model.size());
  std::iota(backwards.rbegin(), backwards.rend(), 0u);
  workspace.model.Select(backwards);
  ASSERT_TRUE(splat::WritePly(model, workspace.model).ok());
  const Status labels = ReadInstanceLabels(workspace.path(), 120).status();
  EXPECT_EQ(labels.code(), StatusCode::kBadInput);
  EXPECT_NE(labels.message().find("of another reconstruction"),
            std::string::npos)
      << labels.message();
  EXPECT_EQ(ReadSceneHierarchy(workspace.path(), 120).status().message(),
            labels.message());

  std::filesystem::remove(model);
  EXPECT_TRUE(CheckBootstrapOfModel(workspace.path()).ok());
}

TEST(SceneInstancesTest, IdsInPicturesAreLabelsPlusOne) {
  const ImageU16 ids = EncodeInstances(RowOfLabels());
  EXPECT_EQ(ids(0, 0), 0);
  EXPECT_EQ(ids(1, 0), 6);
  EXPECT_EQ(ids(3, 0), 0);
}

TEST(SceneInstancesTest, AMaskShowsOneInstance) {
  const ImageU8 mask = InstanceMask(RowOfLabels(), 5);
  EXPECT_EQ(mask(0, 0), 0);
  EXPECT_EQ(mask(2, 0), 255);
}

TEST(SceneInstancesTest, InstancesHaveThePalettesColours) {
  const ImageU8 colors = ColorInstances(RowOfLabels());
  const auto color = semantics::PaletteColor(5);
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(colors(1, 0, c), color[static_cast<size_t>(c)]);
  }
}

TEST(SceneInstancesTest, AnOverlayHasColoursAndOutlines) {
  const ImageU8 photo(4, 1, 3, 200);
  const ImageU8 overlay = OverlayInstances(photo, RowOfLabels());
  const auto color = semantics::PaletteColor(5);
  for (int c = 0; c < 3; ++c) {
    // A line at the last pixel before another label.
    EXPECT_GT(overlay(0, 0, c), 240);
    EXPECT_NEAR(
        overlay(1, 0, c), 0.4 * 200 + 0.6 * color[static_cast<size_t>(c)], 1);
    EXPECT_GT(overlay(2, 0, c), 240);
  }
  const Image<int32_t> nothing(4, 1, 1, -1);
  EXPECT_LT(OverlayInstances(photo, nothing)(1, 0, 0), 100);
}

}  // namespace
}  // namespace freegs::stages
