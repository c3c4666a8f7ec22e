// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/features/sift.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/io/image_io.h"
#include "tests/sfm/textured_photo.h"
#include "tests/temporary_folder.h"

namespace freegs::sfm {
namespace {

// The keypoint nearest to (x, y).
Keypoint Nearest(const SiftFeatures& features, double x, double y) {
  Keypoint nearest;
  double least = 1e9;
  for (const Keypoint& keypoint : features.keypoints) {
    const double distance = std::hypot(keypoint.x - x, keypoint.y - y);
    if (distance >= least) continue;
    least = distance;
    nearest = keypoint;
  }
  return nearest;
}

// Positions are counted from the corner of the image, as COLMAP's.
TEST(FindSift, PlacesBlobs) {
  ImageU8 image(200, 160, 3, 80);
  const double centres[][2] = {{40.5, 50.5}, {90.2, 110.7}, {150.9, 60.1}};
  for (const auto& [x, y] : centres) AddBlob(x, y, 4, 120, &image);
  const SiftFeatures features = FindSift(image, 100);
  for (const auto& [x, y] : centres) {
    const Keypoint keypoint = Nearest(features, x, y);
    EXPECT_NEAR(keypoint.x, x, 0.03);
    EXPECT_NEAR(keypoint.y, y, 0.03);
    EXPECT_NEAR(keypoint.scale, 4, 0.6);
  }
}

TEST(FindSift, LargestFeaturesWithUnitDescriptors) {
  const ImageU8 image = TexturedPhoto(320, 240, 1);
  const SiftFeatures all = FindSift(image, 100000);
  const SiftFeatures some = FindSift(image, 50);
  ASSERT_GT(all.keypoints.size(), 100u);
  ASSERT_EQ(some.keypoints.size(), 50u);
  ASSERT_EQ(some.descriptors.count(), 50u);
  for (size_t i = 0; i < some.keypoints.size(); ++i) {
    EXPECT_EQ(some.keypoints[i].x, all.keypoints[i].x);
    if (i > 0) {
      EXPECT_LE(some.keypoints[i].scale, some.keypoints[i - 1].scale);
    }
    double squared = 0;
    for (size_t k = 0; k < kSiftDimensions; ++k) {
      const double value = some.descriptors.values[i * kSiftDimensions + k];
      EXPECT_EQ(value, all.descriptors.values[i * kSiftDimensions + k]);
      squared += value * value;
    }
    EXPECT_NEAR(std::sqrt(squared), 512, 12);
  }
}

TEST(FindSift, NothingToSee) {
  EXPECT_TRUE(FindSift(ImageU8(), 100).keypoints.empty());
  for (const int side : {1, 2, 7, 64}) {
    const SiftFeatures features = FindSift(ImageU8(side, 3, 3, 90), 100);
    EXPECT_TRUE(features.keypoints.empty());
    EXPECT_EQ(features.descriptors.count(), 0u);
  }
}

class FindPhotoSiftTest : public testing::Test {
 protected:
  TemporaryFolder folder_;
};

// Features of a smaller image are given in pixels of the photo.
TEST_F(FindPhotoSiftTest, ShrinksThePhoto) {
  ImageU8 image(800, 600, 3, 80);
  AddBlob(301.5, 222.25, 12, 120, &image);
  ASSERT_TRUE(WriteImage(folder_ / "photo.png", image).ok());
  const auto features = FindPhotoSift(folder_ / "photo.png", {}, 200, 100);
  ASSERT_TRUE(features.ok()) << features.status().message();
  const Keypoint keypoint = Nearest(*features, 301.5, 222.25);
  EXPECT_NEAR(keypoint.x, 301.5, 0.2);
  EXPECT_NEAR(keypoint.y, 222.25, 0.2);
  EXPECT_NEAR(keypoint.scale, 12, 2);
}

TEST_F(FindPhotoSiftTest, MaskKeepsFeaturesOff) {
  const ImageU8 image = TexturedPhoto(320, 240, 2);
  ASSERT_TRUE(WriteImage(folder_ / "photo.png", image).ok());
  ImageU8 mask(320, 240, 1, 255);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 100; ++x) mask(x, y) = 0;
  }
  ASSERT_TRUE(WriteImage(folder_ / "mask.png", mask).ok());
  const auto all = FindPhotoSift(folder_ / "photo.png", {}, 1600, 5000);
  const auto features =
      FindPhotoSift(folder_ / "photo.png", folder_ / "mask.png", 1600, 5000);
  ASSERT_TRUE(all.ok() && features.ok());
  size_t outside = 0;
  for (const Keypoint& keypoint : all->keypoints) outside += keypoint.x >= 100;
  EXPECT_GT(outside, 0u);
  EXPECT_LT(outside, all->keypoints.size());
  EXPECT_EQ(features->keypoints.size(), outside);
  EXPECT_EQ(features->descriptors.count(), outside);
  for (const Keypoint& keypoint : features->keypoints) {
    EXPECT_GE(keypoint.x, 100);
  }
}

// What the mask takes away has no part in the limit.
TEST_F(FindPhotoSiftTest, AsManyFeaturesBesideAMask) {
  ASSERT_TRUE(
      WriteImage(folder_ / "photo.png", TexturedPhoto(320, 240, 2)).ok());
  ImageU8 mask(320, 240, 1, 0);
  for (int y = 60; y < 180; ++y) {
    for (int x = 80; x < 240; ++x) mask(x, y) = 255;
  }
  ASSERT_TRUE(WriteImage(folder_ / "mask.png", mask).ok());
  const auto features =
      FindPhotoSift(folder_ / "photo.png", folder_ / "mask.png", 1600, 20);
  ASSERT_TRUE(features.ok());
  EXPECT_EQ(features->keypoints.size(), 20u);
}

TEST_F(FindPhotoSiftTest, UnreadableFilesAreNamed) {
  WriteText(folder_ / "photo.png", "pixels");
  auto features = FindPhotoSift(folder_ / "photo.png", {}, 800, 100);
  EXPECT_EQ(features.status().code(), StatusCode::kBadInput);
  EXPECT_THAT(features.status().message(), testing::HasSubstr("photo.png"));
  ASSERT_TRUE(WriteImage(folder_ / "photo.png", TexturedPhoto(64, 64, 1)).ok());
  features =
      FindPhotoSift(folder_ / "photo.png", folder_ / "none.png", 800, 100);
  EXPECT_FALSE(features.ok());
  EXPECT_THAT(features.status().message(), testing::HasSubstr("none.png"));
}

TEST(OneOpenCvThread, LastsAsLongAsItLives) {
  const int before = cv::getNumThreads();
  {
    const OneOpenCvThread one;
    EXPECT_EQ(cv::getNumThreads(), 1);
  }
  EXPECT_EQ(cv::getNumThreads(), before);
}

}  // namespace
}  // namespace freegs::sfm
