// SPDX-License-Identifier: BSD-3-Clause

#include "stages/sfm/sfm_memory.h"

#include <gtest/gtest.h>

#include "pipeline/stage.h"

namespace freegs::stages {
namespace {

photos::PhotoList Photos(size_t count, int width, int height) {
  photos::PhotoList list;
  list.photos.resize(count);
  for (photos::Photo& photo : list.photos) {
    photo.width = width;
    photo.height = height;
  }
  return list;
}

TEST(SfmMemoryTest, GrowsWithPixelsAndThreads) {
  sfm::SfmOptions options;
  const int64_t some = SfmMemory(options, Photos(10, 640, 480), 2);
  EXPECT_GT(SfmMemory(options, Photos(10, 800, 600), 2), some);
  EXPECT_GT(SfmMemory(options, Photos(10, 640, 480), 4), some);
  // Larger images than features are taken from are reduced.
  options.max_image_size = 640;
  EXPECT_EQ(SfmMemory(options, Photos(10, 6400, 4800), 2), some);
  options.max_image_size = 1280;
  EXPECT_GT(SfmMemory(options, Photos(10, 6400, 4800), 2), some);
}

TEST(SfmMemoryTest, GrowsWithPhotosAndFeatures) {
  sfm::SfmOptions options;
  const int64_t some = SfmMemory(options, Photos(300, 640, 480), 1);
  EXPECT_GT(SfmMemory(options, Photos(600, 640, 480), 1), some);
  photos::PhotoList list = Photos(600, 640, 480);
  for (int i = 0; i < 300; ++i) {
    list.photos[i].split = photos::PhotoSplit::kRejected;
  }
  EXPECT_EQ(SfmMemory(options, list, 1), some);
  options.max_features *= 2;
  EXPECT_GT(SfmMemory(options, Photos(300, 640, 480), 1), some);
}

TEST(SfmMemoryTest, UndistortionGrowsWithPixelsAndCores) {
  const int64_t some = UndistortMemory(Photos(10, 640, 480), 2);
  EXPECT_GT(some, pipeline::kProgramMemory);
  EXPECT_GT(UndistortMemory(Photos(10, 1280, 960), 2), some);
  EXPECT_GT(UndistortMemory(Photos(10, 640, 480), 8), some);
}

}  // namespace
}  // namespace freegs::stages
