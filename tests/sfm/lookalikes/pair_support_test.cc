// SPDX-License-Identifier: BSD-3-Clause
// What matches say for and against two poses.

#include "sfm/lookalikes/pair_support.h"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/sfm/match_database_writer.h"
#include "tests/sfm/synthetic_model.h"
#include "tests/temporary_folder.h"

namespace freegs::sfm {
namespace {

// The support of a pair with 100 matches, of which so many are right and the
// others far off.
PairSupport SupportOfPair(int right) {
  const Reconstruction model = SyntheticModel(2, 100);
  const TemporaryFolder folder;
  const std::string path = (folder / "a.db").string();
  {
    std::vector<uint32_t> matches;
    for (int i = 0; i < 100; ++i) {
      const Eigen::Vector2d& pixel = model.images[1].points2d[i].xy;
      int other = i;
      // The photos are beside each other: height tells what is wrong.
      while (i >= right && std::abs(model.images[1].points2d[other].xy.y() -
                                    pixel.y()) < 60) {
        other = (other + 1) % 100;
      }
      matches.push_back(i);
      matches.push_back(other);
    }
    MatchDatabaseWriter(path).Add(1, 2, matches);
  }
  const auto database = MatchDatabase::Open(path);
  EXPECT_TRUE(database.ok());
  const auto pairs = MeasureSupport(model, *database);
  EXPECT_TRUE(pairs.ok());
  return pairs->at(0);
}

TEST(MeasureSupport, HalfRightPairsSayNothing) {
  const PairSupport most = SupportOfPair(80);
  EXPECT_TRUE(most.fits);
  EXPECT_GE(most.supporting, 80);
  EXPECT_LT(most.against, 5);
  const PairSupport half = SupportOfPair(40);
  EXPECT_FALSE(half.fits);
  EXPECT_EQ(half.supporting, 0);
  EXPECT_LT(half.against, 5);
  const PairSupport wrong = SupportOfPair(0);
  EXPECT_FALSE(wrong.fits);
  EXPECT_EQ(wrong.supporting, 0);
  EXPECT_GT(wrong.against, 80);
}

// What supports a pair of 100 right matches, as a share of their number. Its
// database has a homography that explains so many of them, if the number is not
// negative.
double SupportWithHomography(int explained, int config) {
  constexpr double kFarShift = 10;  // Pixels, of what is on the plane.
  constexpr double kNearShift = 30;
  Reconstruction model = SyntheticModel(2, 100);
  const TemporaryFolder folder;
  const std::string path = (folder / "a.db").string();
  {
    std::vector<uint32_t> matches;
    for (uint32_t i = 0; i < 100; ++i) matches.insert(matches.end(), {i, i});
    std::vector<double> homography;
    if (explained >= 0) homography = {1, 0, kFarShift, 0, 1, 0, 0, 0, 1};
    MatchDatabaseWriter(path).Add(1, 2, matches, config, homography);
  }
  // The second camera is beside the first, so that its features are shifted.
  model.images[1].cam_from_world = model.images[0].cam_from_world;
  model.images[1].cam_from_world.translation.x() += 0.5;
  for (int i = 0; i < 100; ++i) {
    model.images[1].points2d[i].xy =
        model.images[0].points2d[i].xy +
        Eigen::Vector2d(i < explained ? kFarShift : kNearShift, 0);
  }
  const auto database = MatchDatabase::Open(path);
  EXPECT_TRUE(database.ok());
  const auto pairs = MeasureSupport(model, *database);
  EXPECT_TRUE(pairs.ok());
  return pairs->at(0).supporting / 100;
}

TEST(MeasureSupport, MatchesThatAHomographyExplainsCountLess) {
  constexpr int kMotion = 3;
  constexpr int kHomography = 6;
  EXPECT_NEAR(SupportWithHomography(-1, kMotion), 1, 1e-9);
  EXPECT_NEAR(SupportWithHomography(-1, kHomography), 0.2, 1e-9);
  // What counts is how many, and not what COLMAP calls it.
  for (const int config : {kMotion, kHomography}) {
    EXPECT_NEAR(SupportWithHomography(50, config), 1, 1e-9);
    EXPECT_NEAR(SupportWithHomography(70, config), 0.6, 1e-9);
    EXPECT_NEAR(SupportWithHomography(90, config), 0.2, 1e-9);
  }
}

// Points are seen at 75 to 85 degrees from the axes of both cameras.
TEST(MeasureSupport, WideFisheyesSupportWhatTheySee) {
  const Eigen::Vector3d beside(0.5, 0, 0);
  Reconstruction model = SyntheticModel(2, 100);
  for (Camera& camera : model.cameras) {
    camera.model = CameraModel::kOpenCvFisheye;
    camera.width = camera.height = 1400;
    camera.params = {400, 400, 700, 700, 0.01, 0, 0, 0};
  }
  const Camera& camera = model.cameras[0];
  model.images[0].cam_from_world = Rigid3d();
  model.images[1].cam_from_world = Rigid3d();
  model.images[1].cam_from_world.translation = beside;
  std::vector<uint32_t> matches;
  for (uint32_t i = 0; i < 100; ++i) {
    const double off_axis = (75 + 0.1 * i) * std::numbers::pi / 180;
    const double around = 2.4 * i;
    const double distance = 4 + i % 7;
    const Eigen::Vector3d point =
        distance * Eigen::Vector3d(std::sin(off_axis) * std::cos(around),
                                   std::sin(off_axis) * std::sin(around),
                                   std::cos(off_axis));
    model.images[0].points2d[i].xy = *Project(camera, point);
    model.images[1].points2d[i].xy = *Project(camera, point + beside);
    matches.insert(matches.end(), {i, i});
  }
  const TemporaryFolder folder;
  const std::string path = (folder / "a.db").string();
  MatchDatabaseWriter(path).Add(1, 2, matches);
  const auto database = MatchDatabase::Open(path);
  ASSERT_TRUE(database.ok());
  const auto pairs = MeasureSupport(model, *database);
  ASSERT_TRUE(pairs.ok());
  EXPECT_TRUE(pairs->at(0).fits);
  EXPECT_GE(pairs->at(0).supporting, 99);
}

}  // namespace
}  // namespace freegs::sfm
