// SPDX-License-Identifier: BSD-3-Clause

#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/image_io.h"
#include "photos/photo_decode.h"
#include "tests/photos/photo_test_files.h"

namespace freegs::photos {
namespace {

TEST(PhotoInspectorTest, FillsTheRecord) {
  const TemporaryFolder folder;
  const std::string exif =
      MakeExif({.orientation = 6, .make = "A", .model = "B", .focal_35mm = 36});
  folder.Write("a/b.jpg", WithExif(MakeJpeg(60, 40, 1), exif));
  PhotoInspector inspector({});
  const InspectedPhoto turned = inspector.Inspect(folder.path(), "a/b.jpg");
  EXPECT_TRUE(turned.photo.usable());
  EXPECT_EQ(turned.photo.format, "JPEG");
  EXPECT_EQ(turned.photo.width, 40);
  EXPECT_EQ(turned.photo.height, 60);
  EXPECT_EQ(turned.photo.orientation, 6);
  EXPECT_EQ(turned.photo.make, "A");
  EXPECT_NEAR(turned.photo.focal_length_px.value_or(0), 60, 1e-6);
  EXPECT_TRUE(turned.photo.converted);
  EXPECT_EQ(turned.pixels.width(), 40);
  EXPECT_EQ(turned.photo.hash.size(), 32U);

  folder.Write("c.jpg", MakeJpeg(60, 40, 1));
  const InspectedPhoto plain = inspector.Inspect(folder.path(), "c.jpg");
  EXPECT_FALSE(plain.photo.converted);
  EXPECT_TRUE(plain.pixels.empty());

  // Its size alone tells.
  folder.Write("large.jpg", "");
  std::filesystem::resize_file(folder / "large.jpg", kMaxPhotoFileBytes + 1);
  EXPECT_THAT(inspector.Inspect(folder.path(), "large.jpg").photo.reason,
              testing::AllOf(testing::StartsWith("larger than"),
                             testing::EndsWith("; reduce it, or remove it")));

  const InspectedPhoto missing = inspector.Inspect(folder.path(), "none.jpg");
  EXPECT_FALSE(missing.photo.usable());
  EXPECT_THAT(missing.photo.reason, testing::StartsWith("cannot read"));
}

// The stages after ingest would refuse the files as they are.
TEST(PhotoInspectorTest, SoundPngWithABadChunkIsConverted) {
  const TemporaryFolder folder;
  const std::string png = MakePng(60, 40, 1);
  const ImageU8 sound = RgbOf(MakePicture(60, 40, 1));
  PhotoInspector inspector({});
  for (const std::string& bytes :
       {WithPngChunk(png, "ABCD", "a"),
        WithPngChunk(png, "tE1t", "a"),
        WithPngDataInTwo(png, PngChunk("tEXt", "a"))}) {
    folder.Write("a.png", bytes);
    EXPECT_FALSE(ReadRgb(folder.path() / "a.png").ok());
    const InspectedPhoto photo = inspector.Inspect(folder.path(), "a.png");
    EXPECT_TRUE(photo.photo.usable()) << photo.photo.reason;
    EXPECT_TRUE(photo.photo.converted);
    EXPECT_EQ(LargestDifference(photo.pixels, sound), 0);
  }
  folder.Write("b.png", WithPngDataInTwo(png, ""));
  EXPECT_FALSE(inspector.Inspect(folder.path(), "b.png").photo.converted);
}

// COLMAP would apply the gamma, and OpenCV would not.
TEST(PhotoInspectorTest, PngWithGammaIsConvertedAsStored) {
  const TemporaryFolder folder;
  const cv::Mat picture = MakePicture(60, 40, 1);
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  PhotoInspector inspector({});
  for (const cv::Mat& stored : {picture, grey}) {
    const std::string png = Encode(".png", stored);
    cv::Mat bgr = stored;
    if (stored.channels() == 1) cv::cvtColor(stored, bgr, cv::COLOR_GRAY2BGR);
    folder.Write("a.png", WithPngChunk(png, "gAMA", Bytes(100000, 4)));
    const InspectedPhoto linear = inspector.Inspect(folder.path(), "a.png");
    EXPECT_TRUE(linear.photo.usable()) << linear.photo.reason;
    EXPECT_TRUE(linear.photo.converted);
    EXPECT_EQ(LargestDifference(linear.pixels, RgbOf(bgr)), 0);

    folder.Write("b.png", WithPngChunk(png, "gAMA", Bytes(45455, 4)));
    EXPECT_FALSE(inspector.Inspect(folder.path(), "b.png").photo.converted);
  }
}

}  // namespace
}  // namespace freegs::photos
