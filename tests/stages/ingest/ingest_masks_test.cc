// SPDX-License-Identifier: BSD-3-Clause

#include "stages/ingest/ingest_masks.h"

#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/image_io.h"
#include "tests/stages/ingest_test_fixture.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

using IngestMasksTest = IngestTestFixture;

TEST_F(IngestMasksTest, MasksBesidePhotos) {
  WritePhotos(4);
  cv::Mat mask(48, 64, CV_8UC1, cv::Scalar(0));
  mask.colRange(0, 16).setTo(cv::Scalar(7));
  const std::string png = photos::Encode(".png", mask);
  images_.Write("masks/img0.jpg.png", png);
  images_.Write("masks/img1.png", png);
  images_.Write("masks/img9.png", png);
  images_.Write("masks/img2.png", photos::MakePng(30, 48, 1));
  ASSERT_TRUE(Run().ok());
  const photos::PhotoList list = List();
  ASSERT_EQ(list.photos.size(), 4U);  // No mask is a photo.
  EXPECT_TRUE(list.photos[0].has_mask);
  EXPECT_TRUE(list.photos[1].has_mask);
  EXPECT_FALSE(list.photos[2].has_mask);
  EXPECT_FALSE(list.photos[3].has_mask);
  EXPECT_EQ(summary_["masks"], 2);
  EXPECT_DOUBLE_EQ(summary_["mask_kept_share"].get<double>(), 0.25);
  EXPECT_THAT(warnings_,
              testing::UnorderedElementsAre(
                  testing::AllOf(HasSubstr("img2.png: mask not used"),
                                 HasSubstr("30 x 48")),
                  testing::AllOf(HasSubstr("1 files fit no photo"),
                                 HasSubstr("img9.png")),
                  HasSubstr("2 of 4 photos have a mask")));
  const fs::path folder = workspace_.path() / "ingest.partial/masks";
  const auto written = ReadLabels(folder / "img1.jpg.png");
  ASSERT_TRUE(written.ok()) << written.status().message();
  EXPECT_EQ((*written)(5, 5), 255);
  EXPECT_EQ((*written)(20, 5), 0);
  // Photos without a mask get a white one.
  EXPECT_EQ((*ReadLabels(folder / "img3.jpg.png"))(5, 5), 255);

  options_.masks.invert_masks = true;
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ((*ReadLabels(folder / "img1.jpg.png"))(5, 5), 0);

  // Without masks, the folder is one of photos.
  options_.masks.use_masks = false;
  ASSERT_TRUE(Run().ok());
  EXPECT_GT(List().photos.size(), 4U);
  EXPECT_FALSE(fs::exists(folder));
}

TEST_F(IngestMasksTest, MasksElsewhere) {
  WritePhotos(3);
  const TemporaryFolder masks;
  options_.masks.masks = masks.path().string();
  const auto paint = [&masks](int value) {
    for (int i = 0; i < 3; ++i) {
      masks.Write(
          "img" + std::to_string(i) + ".jpg.png",
          photos::Encode(".png", cv::Mat(48, 64, CV_8UC1, cv::Scalar(value))));
    }
  };
  paint(0);
  // All black: not used, rather than a scene without features.
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(summary_["masks"], 0);
  EXPECT_THAT(warnings_,
              testing::Contains(HasSubstr(
                  "or, if white is to be ignored, set ingest.invert_masks")));
  EXPECT_FALSE(fs::exists(workspace_.path() / "ingest.partial/masks"));
  // The advice does not name what is already set.
  options_.masks.invert_masks = true;
  paint(255);
  warnings_.clear();
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(warnings_,
              testing::Contains(HasSubstr("set ingest.invert_masks to false")));
  options_.masks.invert_masks = false;
  paint(0);
  pipeline::StageContext context;
  context.images = images_.path();
  EXPECT_THAT(MakeIngestStage(options_)->Inputs(context),
              testing::Contains(masks.path()));

  // The masks beside the photos are not photos all the same.
  images_.Write("masks/img0.jpg.png", photos::MakePng(64, 48, 1));
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(List().photos.size(), 3U);

  options_.masks.masks = "/nonexistent/masks";
  EXPECT_EQ(Run().code(), StatusCode::kBadInput);
}

// Cameras that write two files for each photo leave one that cannot be read.
TEST_F(IngestMasksTest, FilesThatAreNotUsedTakeNoMasks) {
  WritePhotos(3);
  images_.Write("images/a.png", photos::MakePng(64, 48, 1));
  images_.Write("raw/a.dng", "not a photo");
  images_.Write(
      "masks/a.png",
      photos::Encode(".png", cv::Mat(48, 64, CV_8UC1, cv::Scalar(255))));
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(summary_["masks"], 1);
  EXPECT_THAT(warnings_,
              testing::Not(testing::Contains(HasSubstr("fit no photo"))));
}

TEST_F(IngestMasksTest, APhotoThatIsDroppedKeepsItsMask) {
  WritePhotos(3);
  images_.Write("cam1/a.jpg", photos::MakeJpeg(64, 48, 1));
  images_.Write(
      "cam2/a.jpg",
      photos::Encode(".jpg", cv::Mat(48, 64, CV_8UC3, cv::Scalar(9, 9, 9))));
  images_.Write(
      "masks/a.png",
      photos::Encode(".png", cv::Mat(48, 64, CV_8UC1, cv::Scalar(255))));
  const auto dropped = [this] { return Files(photos::PhotoSplit::kRejected); };
  // It could be the mask of the blurred one.
  options_.keep_sharpest = 0.8;
  ASSERT_TRUE(Run().ok());
  ASSERT_THAT(dropped(), testing::ElementsAre("cam2/a.jpg"));
  EXPECT_EQ(summary_["masks"], 0);
  EXPECT_THAT(warnings_, testing::Contains(HasSubstr("or several")));

  // It can only be the mask of the blurred one.
  fs::remove(images_.path() / "cam1/a.jpg");
  options_.keep_sharpest = 0.75;
  ASSERT_TRUE(Run().ok());
  ASSERT_THAT(dropped(), testing::ElementsAre("cam2/a.jpg"));
  EXPECT_EQ(summary_["masks"], 0);
  EXPECT_THAT(warnings_,
              testing::Not(testing::Contains(HasSubstr("fit no photo"))));

  // The same picture in two folders is one photo.
  options_.keep_sharpest = 1;
  images_.Write("copies/a.jpg", ReadText(images_.path() / "cam2/a.jpg"));
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(summary_["masks"], 1);
  EXPECT_THAT(warnings_,
              testing::Not(testing::Contains(HasSubstr("fit no photo"))));
}

TEST_F(IngestMasksTest, MasksInThePhotoFolderItself) {
  WritePhotos(3);
  options_.masks.masks = (images_.path() / ".").string();
  const Status status = Run();
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("a folder of their own"));

  options_.masks.masks.clear();
  fs::create_directory_symlink(images_.path(), images_.path() / "masks");
  EXPECT_THAT(Run().message(), HasSubstr("a folder of their own"));
}

// A link counts with its name in the hash of the folder that it lies in.
TEST_F(IngestMasksTest, LinkedMasksAreInputs) {
  WritePhotos(3);
  const TemporaryFolder masks;
  const TemporaryFolder more;
  masks.Write("img0.png", photos::MakePng(64, 48, 1));
  pipeline::StageContext context;
  context.images = images_.path();
  context.workspace = workspace_.path();
  const auto inputs = [&] {
    return MakeIngestStage(options_)->Inputs(context);
  };
  const fs::path folder = images_.path() / "masks";
  fs::create_directory_symlink(masks.path(), folder);
  EXPECT_THAT(inputs(), testing::ElementsAre(images_.path(), folder / ""));
  fs::create_directory_symlink(more.path(), masks.path() / "sub");
  EXPECT_THAT(
      inputs(),
      testing::ElementsAre(images_.path(), folder / "", folder / "sub" / ""));

  // The hash of a folder that is named follows it, but no links in it.
  fs::remove(folder);
  options_.masks.masks = masks.path().string();
  EXPECT_THAT(inputs(),
              testing::ElementsAre(
                  images_.path(), masks.path(), masks.path() / "sub" / ""));

  // Without links there are no further inputs.
  options_.masks.masks.clear();
  images_.Write("masks/img0.png", photos::MakePng(64, 48, 1));
  EXPECT_THAT(inputs(), testing::ElementsAre(images_.path()));
  fs::create_directory_symlink(more.path(), folder / "sub");
  EXPECT_THAT(inputs(),
              testing::ElementsAre(images_.path(), folder / "sub" / ""));
  options_.masks.use_masks = false;  // A folder of photos like any other.
  EXPECT_THAT(inputs(),
              testing::ElementsAre(images_.path(), folder / "sub" / ""));
}

}  // namespace
}  // namespace freegs::stages
