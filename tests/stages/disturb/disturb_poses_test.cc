// SPDX-License-Identifier: BSD-3-Clause

#include "stages/disturb/disturb_poses.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/rigid3d.h"
#include "sfm/scene/model_io.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

constexpr int kImages = 400;

// Cameras on a line that look along z at one point.
sfm::Reconstruction Model() {
  sfm::Reconstruction model;
  model.cameras.push_back(
      {1, sfm::CameraModel::kPinhole, 640, 480, {500, 400, 320, 240}});
  for (int i = 0; i < kImages; ++i) {
    sfm::PosedImage image;
    image.id = i + 1;
    image.camera_id = 1;
    image.name = std::to_string(i) + ".jpg";
    image.cam_from_world.translation = Eigen::Vector3d(-0.01 * i, 0, 5);
    model.images.push_back(image);
  }
  sfm::Point3D point;
  point.id = 1;
  point.xyz = Eigen::Vector3d(0.1, 0.2, 0.3);
  model.points3d.push_back(point);
  return model;
}

sfm::Reconstruction ModelAfter(const std::string& text, uint64_t seed = 1) {
  sfm::Reconstruction model = Model();
  DisturbModel(*ParseDisturbance(text), seed, &model);
  return model;
}

Eigen::Vector2d Pixel(const sfm::Reconstruction& model, size_t image) {
  return *sfm::Project(
      model.cameras[0],
      model.images[image].cam_from_world * model.points3d[0].xyz);
}

TEST(DisturbPosesTest, JitterMovesPicturesByPixels) {
  const sfm::Reconstruction before = Model();
  const sfm::Reconstruction after = ModelAfter("jitter:2");
  double x = 0, y = 0;
  for (size_t i = 0; i < before.images.size(); ++i) {
    const sfm::PosedImage& image = after.images[i];
    EXPECT_LT((CameraCentre(image.cam_from_world) -
               CameraCentre(before.images[i].cam_from_world))
                  .norm(),
              1e-12);
    // What lay on the optical axis.
    const Eigen::Vector3d axis =
        Inverse(before.images[i].cam_from_world) * Eigen::Vector3d(0, 0, 1);
    const Eigen::Vector2d moved =
        *sfm::Project(after.cameras[0], image.cam_from_world * axis) -
        Eigen::Vector2d(320, 240);
    x += moved.x() * moved.x() / kImages;
    y += moved.y() * moved.y() / kImages;
  }
  EXPECT_NEAR(std::sqrt(x), 2, 0.2);
  EXPECT_NEAR(std::sqrt(y), 2, 0.2);
  EXPECT_EQ(after.points3d[0].xyz, before.points3d[0].xyz);
  EXPECT_NE(Pixel(ModelAfter("jitter:2", 2), 0), Pixel(after, 0));
}

TEST(DisturbPosesTest, AnotherUnitAndPlaceShowTheSame) {
  const sfm::Reconstruction before = Model();
  for (const auto& [text, tolerance] : {std::pair("scale:0.001", 1e-9),
                                        {"scale:1e4", 1e-9},
                                        {"move:1e6", 1e-4}}) {
    const sfm::Reconstruction after = ModelAfter(text);
    EXPECT_NE(after.points3d[0].xyz, before.points3d[0].xyz);
    for (const size_t i : {size_t{0}, size_t{20}}) {
      EXPECT_LT((Pixel(after, i) - Pixel(before, i)).norm(), tolerance) << text;
    }
  }
  EXPECT_NEAR(ModelAfter("move:1e6").points3d[0].xyz.norm(), 1e6, 1);
}

TEST(DisturbPosesTest, ModelsAreReadAndWritten) {
  const TemporaryFolder folder;
  ASSERT_TRUE(sfm::WriteModel(folder / "a", Model()).ok());
  const Disturbance twice{DisturbanceKind::kScale, 2};
  const Status status = DisturbPoses(twice, folder / "a", folder / "b", 1);
  ASSERT_TRUE(status.ok()) << status.message();
  const auto read = sfm::ReadModel(folder / "b");
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->points3d[0].xyz, 2 * Model().points3d[0].xyz);
  EXPECT_FALSE(DisturbPoses(twice, folder / "none", folder / "c", 1).ok());
}

TEST(DisturbPosesTest, PosesWithoutPointsStayWithout) {
  const TemporaryFolder folder;
  const fs::path model = folder / "sfm" / "sparse" / "0";
  ASSERT_TRUE(sfm::WriteModel(model, Model()).ok());
  const Disturbance jitter{DisturbanceKind::kJitter, 2};
  const auto points_with = [&](const std::string& health) {
    WriteText(folder / "sfm" / "health.json", health);
    fs::remove_all(folder / "b");
    EXPECT_TRUE(DisturbPoses(jitter, model, folder / "b", 1).ok());
    const auto read = sfm::ReadModel(folder / "b");
    EXPECT_TRUE(read.ok()) << read.status().message();
    return read->points3d.size();
  };
  const std::string transforms = R"({"source":"imported transforms.json)";
  EXPECT_EQ(points_with(transforms + R"(, points triangulated"})"), 0u);
  EXPECT_EQ(points_with(transforms + R"(, points random"})"), 0u);
  for (const char* health : {R"({"source":"colmap"})",
                             R"({"source":7})",
                             "[]",
                             "no json",
                             R"({"source":"imported COLMAP model"})"}) {
    EXPECT_EQ(points_with(health), Model().points3d.size()) << health;
  }
}

}  // namespace
}  // namespace freegs::stages
