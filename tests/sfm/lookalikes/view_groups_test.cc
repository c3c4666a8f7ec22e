// SPDX-License-Identifier: BSD-3-Clause
// Groups of photos that evidence holds together.

#include "sfm/lookalikes/view_groups.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sfm/lookalikes/missing_correspondences.h"
#include "tests/sfm/match_database_writer.h"
#include "tests/sfm/synthetic_model.h"
#include "tests/sfm/twin_scene.h"
#include "tests/temporary_folder.h"

namespace freegs::sfm {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;
using testing::SizeIs;

ViewGroups Examine(const TwinScene& scene, const Reconstruction& model) {
  const TemporaryFolder folder;
  const std::string path = (folder / "a.db").string();
  scene.WriteMatches(path);
  const auto database = MatchDatabase::Open(path);
  EXPECT_TRUE(database.ok());
  const auto pairs = MeasureSupport(model, *database);
  EXPECT_TRUE(pairs.ok());
  return FindViewGroups(model, *pairs);
}

TEST(ViewGroups, GluedHalvesAreTold) {
  const TwinScene scene(23);
  const ViewGroups found = Examine(scene, scene.Model(true));
  EXPECT_LT(found.score, 0.4);
  ASSERT_THAT(found.groups, SizeIs(2));
  for (const auto& group : found.groups) {
    for (const uint32_t id : group) {
      EXPECT_EQ(scene.InSecondHalf(static_cast<int>(id) - 1),
                scene.InSecondHalf(static_cast<int>(group[0]) - 1));
    }
  }
  EXPECT_FALSE(found.suspects.empty());
  for (const auto& [id1, id2] : found.suspects) {
    EXPECT_FALSE(scene.InSecondHalf(static_cast<int>(id1) - 1));
    EXPECT_TRUE(scene.InSecondHalf(static_cast<int>(id2) - 1));
  }
}

TEST(ViewGroups, RightRingsAreWhole) {
  // 15 photos: 24 degrees apart.
  for (const int count : {15, 23, 40}) {
    const TwinScene scene(count);
    const ViewGroups found = Examine(scene, scene.Model(false));
    EXPECT_GT(found.score, 0.6) << count;
    EXPECT_TRUE(found.consistent()) << count;
    EXPECT_THAT(found.groups, ElementsAre(SizeIs(count)));
    EXPECT_THAT(found.suspects, IsEmpty());
  }
}

// Far points stay in sight, near ones leave it and are new at each step.
TEST(ViewGroups, ForwardMotionIsWhole) {
  Reconstruction model = SyntheticModel(1, 0);
  model.images.clear();
  RandomStream random(5, 1);
  for (int k = 0; k < 2000; ++k) {
    Point3D point;
    point.id = 10 + k;
    point.xyz = {8 * random.Uniform() - 4,
                 8 * random.Uniform() - 4,
                 60 * random.Uniform()};
    model.points3d.push_back(point);
  }
  for (int i = 0; i < 20; ++i) {
    PosedImage image;
    image.id = i + 1;
    image.camera_id = 1;
    image.name = PhotoName(i);
    image.cam_from_world.translation.z() = -2.0 * i;
    for (Point3D& point : model.points3d) {
      const double depth = point.xyz.z() - 2.0 * i;
      const auto pixel =
          Project(model.cameras[0], image.cam_from_world * point.xyz);
      if (depth < 2 || depth > 12 || !pixel || pixel->x() < 0 ||
          pixel->x() > 640 || pixel->y() < 0 || pixel->y() > 480) {
        continue;
      }
      point.track.push_back(
          {image.id, static_cast<uint32_t>(image.points2d.size())});
      image.points2d.push_back({*pixel, point.id});
    }
    model.images.push_back(std::move(image));
  }
  // All that is shared was matched.
  std::vector<PairSupport> pairs;
  for (const SharedView& view : FindMissingCorrespondences(model, AllPairs())) {
    pairs.push_back({view.image_id1,
                     view.image_id2,
                     view.shared,
                     true,
                     0.5 * view.missing});
  }
  EXPECT_GE(pairs.size(), 19u);
  const ViewGroups found = FindViewGroups(model, pairs);
  EXPECT_TRUE(found.consistent());
  EXPECT_GT(found.score, 0.6);
}

// Of 100 matches so many are right, the others far off.
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

TEST(FindViewGroups, NoClaimWithoutEvidence) {
  const Reconstruction two = SyntheticModel(2, 10);
  EXPECT_TRUE(FindViewGroups(two, {{1, 2, 10, false, 900}}).consistent());
  EXPECT_TRUE(FindViewGroups({}, {}).consistent());
  const Reconstruction six = SyntheticModel(6, 10);
  const ViewGroups none = FindViewGroups(six, {});
  EXPECT_THAT(none.groups, ElementsAre(ElementsAre(1, 2, 3, 4, 5, 6)));
  EXPECT_EQ(none.score, 1);
}

TEST(FindViewGroups, CutsWhereMoreIsAgainst) {
  const Reconstruction model = SyntheticModel(6, 10);
  const ViewGroups found = FindViewGroups(model,
                                          {{1, 2, 300, true, 0},
                                           {2, 3, 300, true, 0},
                                           {4, 5, 300, true, 10},
                                           {5, 6, 300, true, 0},
                                           {1, 3, 0, false, 40},
                                           {3, 4, 5, false, 200},
                                           {1, 6, 60, true, 0},
                                           {2, 5, 20, true, 80}});
  EXPECT_THAT(found.groups,
              ElementsAre(ElementsAre(1, 2, 3), ElementsAre(4, 5, 6)));
  EXPECT_THAT(found.suspects, ElementsAre(Pair(1, 6), Pair(2, 5)));
  EXPECT_NEAR(found.score, 85.0 / 365, 1e-9);
  // A little against it is nothing.
  EXPECT_TRUE(FindViewGroups(model,
                             {{1, 2, 300, true, 0},
                              {2, 3, 300, true, 0},
                              {3, 4, 10, false, 25},
                              {4, 5, 300, true, 0},
                              {5, 6, 300, true, 0}})
                  .consistent());
}

TEST(RestrictTo, KeepsWhatTwoPhotosSee) {
  Reconstruction model = SyntheticModel(4, 40);
  // One point that only one photo of the part sees.
  model.points3d[0].track = {model.points3d[0].track[0],
                             model.points3d[0].track[3]};
  RemoveDanglingReferences(&model);
  Reconstruction part = RestrictTo(model, {1, 2});
  EXPECT_EQ(part.images.size(), 2u);
  EXPECT_EQ(part.points3d.size(), 39u);
  EXPECT_TRUE(CheckReconstruction(part).ok());
  EXPECT_EQ(RemoveDanglingReferences(&part), 0u);
}

}  // namespace
}  // namespace freegs::sfm
