// SPDX-License-Identifier: BSD-3-Clause
// Masks: their names, their pixels, and masks that do not fit.

#include "photos/photo_mask.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/photos/photo_test_files.h"

namespace freegs::photos {
namespace {

using testing::HasSubstr;

Photo PhotoOfSize(int width, int height, int orientation = 1) {
  Photo photo;
  photo.width = width;
  photo.height = height;
  photo.orientation = orientation;
  return photo;
}

// `value` on the left half, `other` on the right.
cv::Mat Halves(int width, int height, int value, int other = 0) {
  cv::Mat mask(height, width, CV_8UC1, cv::Scalar(other));
  mask.colRange(0, width / 2).setTo(cv::Scalar(value));
  return mask;
}

TEST(FindMask, BothNames) {
  const TemporaryFolder folder;
  folder.Write("a.jpg.png", "");
  folder.Write("a.png", "");
  folder.Write("sub/b.png", "");
  EXPECT_EQ(FindMask(folder.path(), "a.jpg"), "a.jpg.png");
  EXPECT_EQ(FindMask(folder.path(), "a.jpeg"), "a.png");
  EXPECT_EQ(FindMask(folder.path(), "sub/b.JPG"), "sub/b.png");
  EXPECT_EQ(FindMask(folder.path(), "b.jpg"), std::nullopt);
  EXPECT_EQ(FindMask(folder.path() / "none", "a.jpg"), std::nullopt);
}

TEST(FindMasks, NamesWithoutTheFirstFolder) {
  const TemporaryFolder folder;
  for (const char* name : {"a.png", "b.png", "c.jpg.png", "sub/d.png"}) {
    folder.Write(name, "");
  }
  using testing::ElementsAre;
  EXPECT_THAT(FindMasks(folder.path(),
                        {"images/a.png",
                         "images/b.jpg",
                         "images_2/b.jpg",
                         "c.jpg",
                         "images/c.jpg",
                         "images/sub/d.png",
                         "x/images/a.png",
                         "none.png"}),
              ElementsAre("a.png",
                          std::nullopt,  // Either could be meant.
                          std::nullopt,
                          "c.jpg.png",
                          std::nullopt,  // It is that of c.jpg.
                          "sub/d.png",
                          std::nullopt,
                          std::nullopt));
}

TEST(DecodeMask, AnythingButBlackIsKept) {
  for (const int value : {1, 128, 255}) {
    const auto mask = DecodeMask(Encode(".png", Halves(64, 48, value)),
                                 PhotoOfSize(64, 48),
                                 /*invert=*/false,
                                 {});
    ASSERT_TRUE(mask.ok()) << mask.status().message();
    EXPECT_EQ(mask->channels(), 1);
    EXPECT_EQ((*mask)(10, 10), 255);
    EXPECT_EQ((*mask)(50, 10), 0);
    EXPECT_DOUBLE_EQ(KeptShare(*mask), 0.5);
  }
  for (const int value : {1, 128, 65535}) {
    cv::Mat deep;
    Halves(64, 48, 1).convertTo(deep, CV_16U, value);
    const auto mask =
        DecodeMask(Encode(".png", deep), PhotoOfSize(64, 48), false, {});
    ASSERT_TRUE(mask.ok()) << mask.status().message();
    EXPECT_DOUBLE_EQ(KeptShare(*mask), 0.5) << value;
  }
  const auto inverted = DecodeMask(
      Encode(".png", Halves(64, 40, 255)), PhotoOfSize(64, 40), true, {});
  EXPECT_EQ((*inverted)(10, 10), 0);
  EXPECT_EQ((*inverted)(50, 10), 255);
}

TEST(DecodeMask, JpegNoiseAndTransparency) {
  const auto jpeg = DecodeMask(
      Encode(".jpg", Halves(64, 48, 200, 9)), PhotoOfSize(64, 48), false, {});
  EXPECT_EQ((*jpeg)(10, 10), 255);
  EXPECT_EQ((*jpeg)(50, 10), 0);

  // A cut-out: white all over, transparent on the right.
  cv::Mat cut(48, 64, CV_8UC4, cv::Scalar(255, 255, 255, 0));
  cut.colRange(0, 32).setTo(cv::Scalar(255, 255, 255, 255));
  const auto cut_out =
      DecodeMask(Encode(".png", cut), PhotoOfSize(64, 48), false, {});
  ASSERT_TRUE(cut_out.ok()) << cut_out.status().message();
  EXPECT_EQ((*cut_out)(10, 10), 255);
  EXPECT_EQ((*cut_out)(50, 10), 0);
}

TEST(DecodeMask, SizeAndOrientation) {
  const std::string wide = Encode(".png", Halves(64, 48, 255));
  // Half the size.
  const auto larger = DecodeMask(wide, PhotoOfSize(128, 96), false, {});
  ASSERT_TRUE(larger.ok());
  EXPECT_EQ(larger->width(), 128);
  EXPECT_EQ((*larger)(63, 5), 255);
  EXPECT_EQ((*larger)(64, 5), 0);
  // Orientation 6: the stored left is on top.
  const auto turned = DecodeMask(wide, PhotoOfSize(48, 64, 6), false, {});
  ASSERT_TRUE(turned.ok()) << turned.status().message();
  EXPECT_EQ(turned->height(), 64);
  EXPECT_EQ((*turned)(5, 5), 255);
  EXPECT_EQ((*turned)(5, 60), 0);
  // Upright already.
  const auto upright = DecodeMask(
      Encode(".png", Halves(48, 64, 255)), PhotoOfSize(48, 64, 6), false, {});
  EXPECT_EQ((*upright)(5, 60), 255);
  // An almost square photo has about the shape that is stored.
  for (const int scale : {1, 2}) {
    const auto square =
        DecodeMask(Encode(".png", Halves(204 * scale, 203 * scale, 255)),
                   PhotoOfSize(203, 204, 6),
                   false,
                   {});
    ASSERT_TRUE(square.ok()) << square.status().message();
    EXPECT_EQ((*square)(200, 5), 255);
    EXPECT_EQ((*square)(5, 200), 0);
  }
  // Another shape.
  const auto wrong = DecodeMask(wide, PhotoOfSize(48, 64), false, {});
  EXPECT_EQ(wrong.status().code(), StatusCode::kBadInput);
  EXPECT_THAT(wrong.status().message(), HasSubstr("64 x 48"));
}

TEST(DecodeMask, HostileFiles) {
  const std::string good = MakePng(64, 48, 1);
  for (const std::string& bytes : {std::string(),
                                   std::string("text"),
                                   good.substr(0, good.size() / 2),
                                   WithPngSize(good, 60000, 60000)}) {
    EXPECT_EQ(DecodeMask(bytes, PhotoOfSize(64, 48), false, {}).status().code(),
              StatusCode::kBadInput);
  }
}

}  // namespace
}  // namespace freegs::photos
