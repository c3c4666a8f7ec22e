// SPDX-License-Identifier: BSD-3-Clause
// A turned camera sees the turned picture.

#include "sfm/import/quarter_turn.h"

#include <gtest/gtest.h>

namespace freegs::sfm {
namespace {

constexpr double kWidth = 640;
constexpr double kHeight = 480;

// Each model with parameters that are all different.
Camera CameraOf(const CameraModelInfo& info) {
  Camera camera;
  camera.model = info.model;
  camera.width = static_cast<uint64_t>(kWidth);
  camera.height = static_cast<uint64_t>(kHeight);
  camera.params = {500};
  if (info.num_focal == 2) camera.params.push_back(520);
  camera.params.insert(camera.params.end(), {310, 250});
  while (static_cast<int>(camera.params.size()) < info.num_params) {
    camera.params.push_back(0.003 *
                            static_cast<double>(camera.params.size() - 2));
  }
  return camera;
}

// Where a pixel of the stored picture is in that turned once clockwise: its top
// row becomes the last column.
Eigen::Vector2d TurnedOnce(const Eigen::Vector2d& pixel, double height) {
  return {height - pixel.y(), pixel.x()};
}

TEST(TurnClockwise, PointsFallWhereThePictureHasThem) {
  const Eigen::Vector3d point(0.4, -0.3, 0.2);
  for (const CameraModelInfo& info : CameraModels()) {
    const Camera camera = CameraOf(info);
    ASSERT_TRUE(camera.Check().ok()) << info.name;
    PosedImage image;
    image.cam_from_world.rotation =
        Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized());
    image.cam_from_world.translation = {0.1, 0.2, 3};
    const Eigen::Vector2d pixel =
        *Project(camera, image.cam_from_world * point);
    image.points2d.resize(1);
    image.points2d[0].xy = pixel;
    Eigen::Vector2d expected = pixel;
    for (int turns = 1; turns <= 4; ++turns) {
      expected = TurnedOnce(expected, turns % 2 == 1 ? kHeight : kWidth);
      Camera turned = camera;
      PosedImage turned_image = image;
      TurnClockwise(turns, &turned, &turned_image);
      EXPECT_EQ(turned.width, turns % 2 == 1 ? kHeight : kWidth);
      EXPECT_EQ(turned.height, turns % 2 == 1 ? kWidth : kHeight);
      EXPECT_LT((turned_image.points2d[0].xy - expected).norm(), 1e-9);
      const Eigen::Vector2d seen =
          *Project(turned, turned_image.cam_from_world * point);
      EXPECT_LT((seen - expected).norm(), 1e-9) << info.name << turns;
    }
  }
}

TEST(QuarterTurns, AreThoseOfExifWithoutAMirror) {
  for (int orientation = 1; orientation <= 8; ++orientation) {
    EXPECT_EQ(QuarterTurns(orientation),
              orientation == 6   ? 1
              : orientation == 8 ? 3
                                 : 0);
  }
}

}  // namespace
}  // namespace freegs::sfm
