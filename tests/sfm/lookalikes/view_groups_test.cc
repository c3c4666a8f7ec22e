// SPDX-License-Identifier: BSD-3-Clause
// Groups of photos that evidence holds together.

#include "sfm/lookalikes/view_groups.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sfm/lookalikes/missing_correspondences.h"
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

}  // namespace
}  // namespace freegs::sfm
