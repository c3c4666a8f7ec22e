// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/scene_alignment.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

// A pose of its own for each pair of a folder and a number.
View ViewAt(const std::string& name, int folder, int number) {
  View view;
  view.name = name;
  const double angle = 0.3 * number + folder;
  view.cam_from_world.rotation = Eigen::Quaterniond(
      Eigen::AngleAxisd(angle, Eigen::Vector3d(0.1, 1, 0.2).normalized()));
  view.cam_from_world.translation =
      Eigen::Vector3d(0.2 * number, std::sin(angle), 3.0 + folder);
  return view;
}

TEST(AlignWithViews, AFolderIsNotTakenForAnother) {
  WorkspaceScene scene;
  for (const int number : {1, 2, 4}) {
    scene.train.push_back(
        ViewAt("left/" + std::to_string(number) + ".jpg", 0, number));
  }
  std::vector<View> truth;
  for (int number = 1; number <= 4; ++number) {
    const std::string file = std::to_string(number) + ".jpg";
    scene.holdout.push_back(ViewAt("right/" + file, 1, number));
    truth.push_back(ViewAt("left/" + file, 0, number));
  }
  const auto poses = AlignWithViews(scene, truth, "truth");
  ASSERT_TRUE(poses.ok()) << poses.status().message();
  EXPECT_EQ(poses->residuals.size(), 3u);
  EXPECT_NEAR(poses->max_rotation_deg, 0, 1e-6);
  EXPECT_NEAR(poses->max_centre, 0, 1e-9);
}

TEST(AlignWithViews, EqualFileNamesOfTwoFoldersFindTheirOwn) {
  WorkspaceScene scene;
  std::vector<View> truth;
  for (int folder = 0; folder < 2; ++folder) {
    for (int number = 1; number <= 3; ++number) {
      const std::string name =
          (folder == 0 ? "left/" : "right/") + std::to_string(number);
      scene.train.push_back(ViewAt(name + ".jpg", folder, number));
      truth.push_back(ViewAt(name + ".png", folder, number));
    }
  }
  const auto poses = AlignWithViews(scene, truth, "truth");
  ASSERT_TRUE(poses.ok()) << poses.status().message();
  ASSERT_EQ(poses->residuals.size(), 6u);
  EXPECT_EQ(poses->residuals[0].name, "left/1.png");
  EXPECT_NEAR(poses->max_rotation_deg, 0, 1e-6);
  EXPECT_NEAR(poses->max_centre, 0, 1e-9);
}

TEST(AlignWithViews, ACameraThatTwoPhotosFitIsLeftOut) {
  WorkspaceScene scene;
  std::vector<View> truth;
  for (int number = 1; number <= 4; ++number) {
    const std::string file = std::to_string(number) + ".jpg";
    scene.train.push_back(ViewAt("left/" + file, 0, number));
    truth.push_back(ViewAt(file, 0, number));
  }
  // Which of the two is 4.jpg, nobody can say.
  scene.train.push_back(ViewAt("right/4.jpg", 1, 4));
  const auto poses = AlignWithViews(scene, truth, "truth");
  ASSERT_TRUE(poses.ok()) << poses.status().message();
  EXPECT_EQ(poses->residuals.size(), 3u);
  EXPECT_NEAR(poses->max_centre, 0, 1e-9);

  scene.train = {scene.train[0], scene.train[3], scene.train[4]};
  EXPECT_EQ(AlignWithViews(scene, truth, "truth").status().code(),
            StatusCode::kBadInput);
}

TEST(AlignWithViews, PhotosWithoutPosesKeepTheirCameras) {
  WorkspaceScene scene;
  std::vector<View> truth;
  for (int number = 1; number <= 3; ++number) {
    const std::string file = std::to_string(number) + ".jpg";
    scene.without_pose.push_back("left/" + file);
    scene.train.push_back(ViewAt("right/" + file, 1, number));
    truth.push_back(ViewAt("left/" + file, 0, number));
  }
  EXPECT_EQ(AlignWithViews(scene, truth, "truth").status().code(),
            StatusCode::kBadInput);
}

}  // namespace
}  // namespace freegs::stages
