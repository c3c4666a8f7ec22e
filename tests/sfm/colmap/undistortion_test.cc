// SPDX-License-Identifier: BSD-3-Clause
// Undistortion: photos that need none, and COLMAP's answers.

#include "sfm/colmap/undistortion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/image_io.h"
#include "sfm/scene/model_io.h"
#include "sfm/scene/model_io_binary.h"
#include "tests/sfm/fake_colmap.h"
#include "tests/sfm/synthetic_model.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class UndistortionTest : public testing::Test {
 protected:
  UndistortionTest() {
    input_.photo_folder = folder_ / "photos";
    input_.output = folder_ / "output";
    input_.colmap = MakeFakeColmap(folder_.path());
  }

  void WritePhotos(const Reconstruction& model) {
    for (const PosedImage& image : model.images) {
      WriteText(input_.photo_folder / image.name, "pixels of " + image.name);
    }
  }

  void WriteImages(const Reconstruction& model, const ImageU8& pixels) {
    fs::create_directories(input_.photo_folder);
    for (const PosedImage& image : model.images) {
      ASSERT_TRUE(WriteImage(input_.photo_folder / image.name, pixels).ok());
    }
  }

  TemporaryFolder folder_;
  UndistortionInput input_;
};

TEST_F(UndistortionTest, PinholePhotosAreKept) {
  input_.colmap = "/nonexistent";  // Not needed.
  Reconstruction model = SyntheticModel(3, 5, CameraModel::kSimpleRadial);
  model.cameras[0].params[3] = 0;
  model.images[1].name = "sub folder/b.jpg";
  WritePhotos(model);
  const auto result = Undistort(model, input_);
  ASSERT_TRUE(result.ok()) << result.status().message();
  EXPECT_FALSE(result->resampled);
  const auto written = ReadModel(input_.output / "sparse");
  ASSERT_TRUE(written.ok());
  EXPECT_EQ(written->cameras[0].model, CameraModel::kPinhole);
  EXPECT_EQ(written->cameras[0].params,
            (std::vector<double>{600, 600, 322, 239}));
  EXPECT_EQ(PointsToBinary(written->points3d), PointsToBinary(model.points3d));
  EXPECT_EQ(ReadText(input_.output / "images" / "sub folder" / "b.jpg"),
            "pixels of sub folder/b.jpg");
  // Editing one of the two files leaves the other alone.
  EXPECT_EQ(fs::hard_link_count(input_.photo_folder / "sub folder" / "b.jpg"),
            1U);
  EXPECT_TRUE(Undistort(model, input_).ok());  // Again, over the same folder.
}

TEST_F(UndistortionTest, LargePinholePhotosAreResized) {
  const Reconstruction model = SyntheticModel(2, 5, CameraModel::kPinhole);
  WriteImages(model, ImageU8(640, 480, 3, 77));
  input_.max_image_size = 160;
  const auto result = Undistort(model, input_);
  ASSERT_TRUE(result.ok()) << result.status().message();
  EXPECT_TRUE(result->resampled);
  const Camera& camera = result->model.cameras[0];
  EXPECT_EQ(camera.width, 160u);
  EXPECT_EQ(camera.height, 120u);
  EXPECT_EQ(camera.FocalX(), 150);
  const auto photo =
      ReadRgb(input_.output / "images" / result->model.images[0].name);
  ASSERT_TRUE(photo.ok());
  EXPECT_EQ(photo->width(), 160);
  const auto pixel = Project(
      camera, result->model.images[0].cam_from_world * model.points3d[0].xyz);
  EXPECT_NEAR(
      (*pixel - result->model.images[0].points2d[0].xy).norm(), 0, 1e-9);
}

// A strip of one pixel cannot become any narrower.
TEST_F(UndistortionTest, PhotosOfTheSameWidthButAnotherHeightAreResized) {
  Reconstruction model = SyntheticModel(2, 5, CameraModel::kPinhole);
  model.cameras[0].width = 1;
  model.cameras[0].height = 640;
  model.cameras[0].params = {600, 600, 0.5, 320};
  WriteImages(model, ImageU8(1, 640, 3, 77));
  input_.max_image_size = 400;
  const auto result = Undistort(model, input_);
  ASSERT_TRUE(result.ok()) << result.status().message();
  EXPECT_TRUE(result->resampled);
  const auto photo =
      ReadRgb(input_.output / "images" / result->model.images[0].name);
  ASSERT_TRUE(photo.ok());
  EXPECT_EQ(photo->width(), 1);
  EXPECT_EQ(photo->height(), 400);
}

TEST_F(UndistortionTest, DistortedPhotosGoThroughColmap) {
  const Reconstruction model = SyntheticModel(3, 5, CameraModel::kRadial);
  WritePhotos(model);
  double done = 0;
  input_.progress = [&](const Progress& progress) { done = progress.done; };
  const auto result = Undistort(model, input_);
  ASSERT_TRUE(result.ok()) << result.status().message();
  EXPECT_TRUE(result->resampled);
  EXPECT_GT(done, 0);
  const auto written = ReadModel(input_.output / "sparse");
  ASSERT_TRUE(written.ok());
  EXPECT_EQ(written->cameras[0].model, CameraModel::kPinhole);
  EXPECT_TRUE(fs::exists(input_.output / "images" / PhotoName(0)));
  EXPECT_FALSE(fs::exists(input_.output / "undistorter"));
}

TEST_F(UndistortionTest, RemainingDistortionIsNoticed) {
  input_.colmap = MakeFakeColmap(folder_.path(), {{"FAKE_COLMAP_KEEP", "1"}});
  const Reconstruction model = SyntheticModel(3, 5);
  WritePhotos(model);
  const auto result = Undistort(model, input_);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.status().code(), StatusCode::kUnusableResult);
  EXPECT_THAT(result.status().message(), HasSubstr("PINHOLE"));
}

TEST_F(UndistortionTest, FailuresAndMissingPhotos) {
  const Reconstruction model = SyntheticModel(9, 5);
  WritePhotos(model);
  input_.colmap = MakeFakeColmap(folder_.path(),
                                 {{"FAKE_COLMAP_FAIL", "image_undistorter"}});
  EXPECT_EQ(Undistort(model, input_).status().code(),
            StatusCode::kUnusableResult);
  input_.colmap = MakeFakeColmap(
      folder_.path(),
      {{"FAKE_COLMAP_FAIL", "image_undistorter"}, {"FAKE_COLMAP_SIGNAL", "9"}});
  EXPECT_EQ(Undistort(model, input_).status().code(), StatusCode::kInternal);
  fs::remove(input_.photo_folder / PhotoName(4));
  const auto missing = Undistort(model, input_);
  EXPECT_EQ(missing.status().code(), StatusCode::kBadInput);
  EXPECT_THAT(missing.status().message(), HasSubstr(PhotoName(4)));
}

}  // namespace
}  // namespace freegs::sfm
