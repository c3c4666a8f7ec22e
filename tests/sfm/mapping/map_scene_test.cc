// SPDX-License-Identifier: BSD-3-Clause
// Which photos are mapped, and in which order, on a fake COLMAP.

#include "sfm/mapping/map_scene.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/image_io.h"
#include "tests/sfm/mapping/structure_from_motion_fixture.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class MapSceneTest : public StructureFromMotionTest {
 protected:
  MapSceneTest() {
    TakePhotos(20);
    options_.fewest_for_skeleton = 20;
  }
};

TEST_F(MapSceneTest, ManyPhotosAreRegisteredToAPartOfThem) {
  for (const char* dialect : {"3", "4"}) {
    fs::remove_all(input_.work_folder);
    const auto result = Run({{"FAKE_COLMAP_DIALECT", dialect}});
    ASSERT_TRUE(result.ok()) << result.status().message();
    EXPECT_THAT(AttemptNames(result->attempts),
                testing::ElementsAre("mapping, part of the photos first"));
    EXPECT_TRUE(result->attempts[0].kept);
    ASSERT_EQ(result->models.size(), 1u);
    EXPECT_EQ(result->models[0].images.size(), 20u);
    EXPECT_EQ(result->models[0].points3d.size(), 150u);
    EXPECT_TRUE(result->warnings.empty());
    // Of photos that all match, seven give each of them six partners.
    EXPECT_THAT(Log("mapper"), HasSubstr("7)"));
    EXPECT_THAT(Log("mapper"), Not(HasSubstr("8)")));
  }
}

TEST_F(MapSceneTest, APartThatPlacesTooFewIsNotKept) {
  const auto result = Run({{"FAKE_COLMAP_OTHERS", "5"}});
  ASSERT_TRUE(result.ok()) << result.status().message();
  EXPECT_THAT(
      AttemptNames(result->attempts),
      testing::ElementsAre("mapping, part of the photos first", "mapping"));
  EXPECT_FALSE(result->attempts[0].kept);
  EXPECT_EQ(result->attempts[0].registered, 12);
  EXPECT_THAT(result->attempts[0].problem, HasSubstr("8 photos left out"));
  EXPECT_EQ(result->models[0].images.size(), 20u);
  EXPECT_TRUE(result->warnings.empty());
}

TEST_F(MapSceneTest, AProgramThatFailsOnAPartIsPassedOver) {
  for (const char* command : {"image_registrator", "point_triangulator"}) {
    fs::remove_all(input_.work_folder);
    const auto result = Run({{"FAKE_COLMAP_FAIL", command}});
    ASSERT_TRUE(result.ok()) << result.status().message();
    ASSERT_THAT(
        AttemptNames(result->attempts),
        testing::ElementsAre("mapping, part of the photos first", "mapping"));
    EXPECT_THAT(result->attempts[0].problem, HasSubstr(command));
    EXPECT_EQ(result->models[0].images.size(), 20u);
  }
}

TEST_F(MapSceneTest, APartOfWhichMostGetNoPoseIsNoModel) {
  const auto result = Run({{"FAKE_COLMAP_MODELS", "6"}});
  ASSERT_TRUE(result.ok()) << result.status().message();
  EXPECT_THAT(result->attempts.at(0).problem, HasSubstr("6 of 7"));
  EXPECT_EQ(result->attempts.at(1).name, "mapping");
}

TEST_F(MapSceneTest, WhereNoPartIsMappedFirst) {
  const auto expect_plain = [&] {
    fs::remove_all(input_.work_folder);
    const auto result = Run();
    ASSERT_TRUE(result.ok()) << result.status().message();
    EXPECT_THAT(AttemptNames(result->attempts),
                testing::ElementsAre("mapping"));
  };
  options_.fewest_for_skeleton = 21;
  expect_plain();
  // Nothing would adjust what comes of a part.
  options_.fewest_for_skeleton = 20;
  options_.camera_model = "RADIAL";
  expect_plain();
  // A part would have the photos of one of two places only.
  options_.camera_model = "auto";
  const ImageU8 elsewhere = TexturedPhoto(160, 120, 2);
  for (int i = 10; i < 20; ++i) {
    EXPECT_TRUE(
        WriteImage(input_.photo_folder / input_.photos[i].name, elsewhere)
            .ok());
  }
  expect_plain();
}

}  // namespace
}  // namespace freegs::sfm
