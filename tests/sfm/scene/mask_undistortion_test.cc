// SPDX-License-Identifier: BSD-3-Clause
// Masks of photos whose distortion has been removed.

#include "sfm/scene/mask_undistortion.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace freegs::sfm {
namespace {

Camera PinholeCamera(uint64_t width, uint64_t height, double focal) {
  return {.id = 1,
          .model = CameraModel::kPinhole,
          .width = width,
          .height = height,
          .params = {focal, focal, width / 2.0, height / 2.0}};
}

TEST(MaskUndistortion, SameCameraKeepsTheMask) {
  const Camera camera = PinholeCamera(7, 5, 6);
  ImageU8 mask(7, 5, 1, 1);
  mask(3, 2) = 0;
  mask(6, 4) = 0;
  const ImageU8 moved = UndistortMask(mask, camera, camera);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 7; ++x) {
      EXPECT_EQ(moved(x, y), mask(x, y) != 0 ? 255 : 0) << x << " " << y;
    }
  }
}

TEST(MaskUndistortion, SmallerPhotoHasASmallerMask) {
  ImageU8 mask(8, 6, 1, 255);
  for (int y = 0; y < 6; ++y) std::fill_n(mask.row(y), 4, uint8_t{0});
  const ImageU8 moved =
      UndistortMask(mask, PinholeCamera(8, 6, 10), PinholeCamera(4, 3, 5));
  ASSERT_EQ(moved.width(), 4);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 4; ++x) EXPECT_EQ(moved(x, y), x < 2 ? 0 : 255);
  }
}

// With k = -0.4 a ray at 0.5 from the centre is seen at 0.5 (1 - 0.1).
TEST(MaskUndistortion, FollowsTheDistortion) {
  Camera camera = PinholeCamera(200, 100, 100);
  camera.model = CameraModel::kSimpleRadial;
  camera.params = {100, 100, 50, -0.4};
  ImageU8 mask(200, 100, 1, 255);
  for (int y = 0; y < 100; ++y) {
    std::fill_n(mask.row(y) + 145, 55, uint8_t{0});  // From u = 0.45 on.
  }
  const ImageU8 moved =
      UndistortMask(mask, camera, PinholeCamera(200, 100, 100));
  EXPECT_EQ(moved(148, 50), 255);  // u = 0.485 is seen at 0.439.
  EXPECT_EQ(moved(152, 50), 0);    // u = 0.525 is seen at 0.467.
}

TEST(MaskUndistortion, WhatThePhotoDidNotShowIsIgnored) {
  const ImageU8 mask(10, 10, 1, 255);
  // Half the focal length: the pinhole camera sees twice as far to each side.
  const ImageU8 moved =
      UndistortMask(mask, PinholeCamera(10, 10, 20), PinholeCamera(10, 10, 10));
  EXPECT_EQ(moved(1, 5), 0);
  EXPECT_EQ(moved(5, 5), 255);
  EXPECT_EQ(moved(8, 5), 0);
}

}  // namespace
}  // namespace freegs::sfm
