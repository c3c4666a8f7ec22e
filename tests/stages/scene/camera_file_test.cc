// SPDX-License-Identifier: BSD-3-Clause
// Camera files that are a transforms.json. tests/stages/evaluation has those
// with sections.

#include "stages/scene/camera_file.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

using testing::HasSubstr;

// A file of one frame that looks along +z from (1, 2, 3), x to the right.
std::string Transforms(const std::string& fields,
                       const std::string& name = "./images/a.png") {
  return R"({"frames": [{"file_path": ")" + name + "\", " + fields +
         R"("transform_matrix": [[1, 0, 0, 1], [0, -1, 0, 2], [0, 0, -1, 3],)" +
         R"( [0, 0, 0, 1]]}]})";
}

constexpr char kIntrinsics[] =
    R"("w": 640, "h": 480, "fl_x": 500, "fl_y": 510, "cx": 321, "cy": 239, )";

TEST(CameraFile, ATransformsFileHasACameraForEachFrame) {
  const auto cameras = ParseCameraSet(Transforms(kIntrinsics), "t.json");
  ASSERT_TRUE(cameras.ok()) << cameras.status().message();
  ASSERT_EQ(cameras->train.size(), 1u);
  EXPECT_TRUE(cameras->test.empty());
  const View& view = cameras->train[0];
  EXPECT_EQ(view.name, "images/a.png");
  EXPECT_EQ(view.camera.width, 640);
  EXPECT_EQ(view.camera.fy, 510);
  EXPECT_EQ(view.camera.cy, 239);
  EXPECT_TRUE(view.cam_from_world.rotation.isApprox(
      Eigen::Quaterniond::Identity(), 1e-12));
  EXPECT_TRUE(view.cam_from_world.translation.isApprox(
      Eigen::Vector3d(-1, -2, -3), 1e-12));
}

TEST(CameraFile, FramesForEvaluationAreTestViews) {
  std::string text = Transforms(kIntrinsics);
  text.insert(1, R"("test_filenames": ["./images/a.png"], )");
  const auto cameras = ParseCameraSet(text, "t.json");
  ASSERT_TRUE(cameras.ok()) << cameras.status().message();
  EXPECT_TRUE(cameras->train.empty());
  EXPECT_EQ(cameras->test.size(), 1u);
}

TEST(CameraFile, WhatNoPictureCanBeRenderedOfIsRefused) {
  const auto refusal = [](const std::string& text) {
    const auto cameras = ParseCameraSet(text, "t.json");
    return cameras.ok() ? "none" : cameras.status().message();
  };
  EXPECT_THAT(refusal(Transforms(std::string(kIntrinsics) + R"("k1": 0.1, )")),
              HasSubstr("t.json: frame \"./images/a.png\": has distortion"));
  EXPECT_THAT(refusal(Transforms(R"("camera_angle_x": 0.7, )")),
              HasSubstr("\"w\" and \"h\""));
  EXPECT_THAT(refusal(Transforms(kIntrinsics, "../a.png")),
              HasSubstr("not the name of a photo"));
  EXPECT_THAT(refusal(R"({"frames": 3})"), HasSubstr("t.json"));
}

}  // namespace
}  // namespace freegs::stages
