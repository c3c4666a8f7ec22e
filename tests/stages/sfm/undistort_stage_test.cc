// SPDX-License-Identifier: BSD-3-Clause
// The undistort stage, on a fake COLMAP.

#include "stages/sfm/undistort_stage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/image_io.h"
#include "sfm/scene/model_io.h"
#include "sfm/scene/views.h"
#include "tests/sfm/fake_colmap.h"
#include "tests/stages/sfm_workspace.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class UndistortStageTest : public testing::Test {
 protected:
  Status Run(const sfm::Reconstruction& model,
             sfm::ModelFormat format = sfm::ModelFormat::kBinary) {
    const fs::path sparse = workspace_.path() / "sfm" / "sparse" / "0";
    FREEGS_RETURN_IF_ERROR(sfm::WriteModel(sparse, model, format));
    return workspace_.Run(
        *MakeUndistortStage({}, sfm::MakeFakeColmap(folder_.path())));
  }

  TemporaryFolder folder_;
  SfmWorkspace workspace_{4};
};

TEST_F(UndistortStageTest, DistortedModel) {
  const Status status =
      Run(sfm::SyntheticModel(4, 10), sfm::ModelFormat::kText);
  ASSERT_TRUE(status.ok()) << status.message();
  const fs::path output = workspace_.path() / "undistort";
  EXPECT_EQ(sfm::DetectModelFormat(output / "sparse"),
            sfm::ModelFormat::kBinary);
  const auto model = sfm::ReadModel(output / "sparse");
  ASSERT_TRUE(model.ok());
  EXPECT_TRUE(sfm::MakeViews(*model).ok());
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(fs::exists(output / "images" / sfm::PhotoName(i)));
  }
  EXPECT_EQ(workspace_.summary["undistorted"], true);
  EXPECT_EQ(workspace_.summary["resampled"], true);
}

TEST_F(UndistortStageTest, PinholeModelIsNotResampled) {
  ASSERT_TRUE(Run(sfm::SyntheticModel(4, 10, sfm::CameraModel::kPinhole)).ok());
  EXPECT_EQ(workspace_.summary["undistorted"], true);
  EXPECT_EQ(workspace_.summary["resampled"], false);
  const auto bytes = [&](const char* folder) {
    return ReadText(workspace_.path() / folder / sfm::PhotoName(0));
  };
  EXPECT_TRUE(bytes("undistort/images") == bytes("ingest/photos"));
  EXPECT_FALSE(bytes("ingest/photos").empty());
}

TEST_F(UndistortStageTest, MasksFollowTheirPhotos) {
  const fs::path masks = workspace_.path() / "ingest" / "masks";
  const std::string name = sfm::PhotoName(1) + ".png";
  fs::create_directories((masks / name).parent_path());
  ImageU8 mask(640, 480, 1, 255);
  for (int y = 0; y < 480; ++y) std::fill_n(mask.row(y), 100, uint8_t{0});
  ASSERT_TRUE(WriteImage(masks / name, mask).ok());
  const auto model = sfm::SyntheticModel(4, 10, sfm::CameraModel::kPinhole);
  const Status status = Run(model);
  ASSERT_TRUE(status.ok()) << status.message();
  const fs::path written = workspace_.path() / "undistort" / "masks";
  const auto moved = ReadLabels(written / name);
  ASSERT_TRUE(moved.ok()) << moved.status().message();
  EXPECT_EQ(moved->width(), 640);
  EXPECT_EQ((*moved)(99, 240), 0);
  EXPECT_EQ((*moved)(100, 240), 255);
  EXPECT_FALSE(fs::exists(written / (sfm::PhotoName(0) + ".png")));
  // A mask of another size.
  ASSERT_TRUE(WriteImage(masks / name, ImageU8(480, 640, 1, 255)).ok());
  EXPECT_EQ(Run(model).code(), StatusCode::kBadInput);
  // Masks that are gone leave none behind.
  fs::remove_all(masks);
  ASSERT_TRUE(Run(model).ok());
  EXPECT_FALSE(fs::exists(written));
}

TEST_F(UndistortStageTest, ForeignModels) {
  // A pose without a photo.
  const Status missing = Run(sfm::SyntheticModel(5, 10));
  EXPECT_EQ(missing.code(), StatusCode::kBadInput);
  EXPECT_THAT(missing.message(), HasSubstr(sfm::PhotoName(4)));
  // Tracks that do not fit.
  sfm::Reconstruction model = sfm::SyntheticModel(4, 10);
  model.points3d[0].track.push_back({77, 3});
  EXPECT_TRUE(Run(model).ok());
  // No model at all.
  fs::remove_all(workspace_.path() / "sfm");
  EXPECT_EQ(workspace_.Run(*MakeUndistortStage({}, "colmap")).code(),
            StatusCode::kBadInput);
}

}  // namespace
}  // namespace freegs::stages
