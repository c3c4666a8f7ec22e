// SPDX-License-Identifier: BSD-3-Clause
// Points for known poses, on a fake COLMAP.

#include "sfm/mapping/known_poses.h"

#include <csignal>
#include <optional>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sfm/matching/match_database.h"
#include "sfm/scene/model_io_binary.h"
#include "tests/sfm/fake_colmap.h"
#include "tests/sfm/synthetic_model.h"
#include "tests/sfm/textured_photo.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using Settings = std::vector<std::pair<std::string, std::string>>;

class KnownPosesTest : public testing::Test {
 protected:
  KnownPosesTest() {
    input_.photo_folder = folder_ / "photos";
    input_.work_folder = folder_ / "work";
    for (int i = 0; i < 6; ++i) {
      SfmPhoto photo;
      photo.name = PhotoName(i);
      photo.width = 640;
      photo.height = 480;
      input_.photos.push_back(photo);
    }
    const ImageU8 image = TexturedPhoto(640, 480, 1);
    fs::create_directories(input_.photo_folder);
    for (const SfmPhoto& photo : input_.photos) {
      EXPECT_TRUE(WriteImage(input_.photo_folder / photo.name, image).ok());
    }
    // The last photo has no pose.
    poses_ = SyntheticModel(5, 20);
    for (PosedImage& image : poses_.images) image.id += 70;
  }

  StatusOr<TriangulatedScene> Run(const Settings& settings = {},
                                  int num_threads = 2) {
    SfmOptions options;
    options.num_threads = num_threads;
    options.colmap = MakeFakeColmap(folder_.path(), settings);
    return TriangulateScene(input_, options, poses_);
  }

  TemporaryFolder folder_;
  SfmInput input_;
  Reconstruction poses_;
};

TEST_F(KnownPosesTest, PosesStayAndPointsCome) {
  const auto scene = Run();
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  const Reconstruction& model = scene->model;
  ASSERT_THAT(model.images, SizeIs(5));
  for (size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(model.images[i].name, PhotoName(static_cast<int>(i)));
    EXPECT_TRUE(model.images[i].cam_from_world.translation.isApprox(
        poses_.images[i].cam_from_world.translation));
  }
  EXPECT_EQ(model.cameras[0].params, poses_.cameras[0].params);
  EXPECT_THAT(model.points3d, SizeIs(150));
  // The grey of the photos, not the black of COLMAP.
  EXPECT_GT(model.points3d[0].rgb[1], 20);
  EXPECT_EQ(scene->fitting_share, 1);
  EXPECT_THAT(scene->findings, IsEmpty());
  EXPECT_EQ(scene->pairs.pairs, 10);
  EXPECT_EQ(scene->colmap_version, "3.8");
  EXPECT_FALSE(fs::exists(input_.work_folder / "triangulation"));
}

TEST_F(KnownPosesTest, EachPhotoIsMatchedWithItsOwnCamera) {
  Camera fisheye = SyntheticModel(1, 1, CameraModel::kOpenCvFisheye).cameras[0];
  fisheye.id = 40;
  poses_.cameras.push_back(fisheye);
  poses_.images[3].camera_id = 40;
  const auto scene = Run();
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  const auto database = MatchDatabase::Open(input_.work_folder / "database.db");
  ASSERT_TRUE(database.ok());
  const auto cameras = database->CameraIds();
  ASSERT_TRUE(cameras.ok());
  std::set<uint32_t> ids;
  for (const auto& [name, id] : *cameras) ids.insert(id);
  EXPECT_THAT(ids, SizeIs(5));
  // The cameras of the import come back.
  const Reconstruction& model = scene->model;
  ASSERT_THAT(model.cameras, SizeIs(2));
  EXPECT_EQ(model.cameras[1].params, fisheye.params);
  EXPECT_EQ(model.images[3].camera_id, 40u);
  EXPECT_EQ(model.images[4].camera_id, poses_.cameras[0].id);
}

TEST_F(KnownPosesTest, AnyNumberOfThreads) {
  const auto one = Run({}, 1);
  fs::remove_all(input_.work_folder);
  const auto three = Run({}, 3);
  ASSERT_TRUE(one.ok() && three.ok());
  EXPECT_EQ(PointsToBinary(one->model.points3d),
            PointsToBinary(three->model.points3d));
}

TEST_F(KnownPosesTest, PosesThatDoNotFitAreTold) {
  const auto scene =
      Run({{"FAKE_COLMAP_POINTS", "0"}, {"FAKE_COLMAP_DIALECT", "4"}});
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_THAT(scene->model.points3d, IsEmpty());
  EXPECT_EQ(scene->fitting_share, 0);
  ASSERT_THAT(scene->findings, SizeIs(1));
  EXPECT_EQ(FindingName(scene->findings[0].kind), "unfit_poses");
  EXPECT_THAT(scene->findings[0].message, HasSubstr("imported poses"));
}

TEST_F(KnownPosesTest, WithoutMatchesNothingIsSaidAboutThePoses) {
  // A single photo with a pose has no other to be matched with.
  poses_.images.resize(1);
  const auto scene =
      Run({{"FAKE_COLMAP_POINTS", "0"}, {"FAKE_COLMAP_DIALECT", "4"}});
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_THAT(scene->model.points3d, IsEmpty());
  EXPECT_EQ(scene->fitting_share, std::nullopt);
  EXPECT_THAT(scene->findings, IsEmpty());
}

TEST(PhotosThatDoNotFit, AreThoseThatOthersContradict) {
  std::vector<PairFit> pairs;
  for (uint32_t a = 1; a <= 6; ++a) {
    for (uint32_t b = a + 1; b <= 6; ++b) pairs.push_back({a, b, 40, 36});
  }
  EXPECT_THAT(PhotosThatDoNotFit(pairs), IsEmpty());
  // The poses of photos 2 and 5 are exchanged.
  for (PairFit& pair : pairs) {
    for (const uint32_t id : {pair.id1, pair.id2}) {
      if (id == 2 || id == 5) pair.fitting = 4;
    }
  }
  const auto found = PhotosThatDoNotFit(pairs);
  ASSERT_THAT(found, SizeIs(2));
  EXPECT_DOUBLE_EQ(found.at(2), 0.1);
  EXPECT_DOUBLE_EQ(found.at(5), 0.1);
}

TEST(PhotosThatDoNotFit, AreNotThoseOfWhichLittleIsKnown) {
  // Photos 7, 8 and 9 match each other only.
  const std::vector<PairFit> pairs = {{1, 2, 90, 80},
                                      {2, 3, 90, 80},
                                      {3, 4, 29, 0},
                                      {7, 8, 189, 0},
                                      {8, 9, 28, 0}};
  EXPECT_THAT(PhotosThatDoNotFit(pairs), IsEmpty());
}

// It would crash again, so the next run need not try.
TEST_F(KnownPosesTest, ACrashIsAVerdict) {
  const auto crashed = Run({{"FAKE_COLMAP_POINTS", "0"}});
  EXPECT_EQ(crashed.status().code(), StatusCode::kUnusableResult);
  EXPECT_THAT(crashed.status().message(), HasSubstr("signal 6"));
  EXPECT_THAT(crashed.status().message(), HasSubstr("Check failed"));
  EXPECT_FALSE(fs::exists(input_.work_folder / "triangulation"));
  const auto killed = Run({{"FAKE_COLMAP_FAIL", "point_triangulator"},
                           {"FAKE_COLMAP_SIGNAL", std::to_string(SIGKILL)}});
  EXPECT_EQ(killed.status().code(), StatusCode::kInternal);
}

TEST_F(KnownPosesTest, FailedOrMissingColmapIsAnError) {
  EXPECT_EQ(Run({{"FAKE_COLMAP_FAIL", "point_triangulator"}}).status().code(),
            StatusCode::kUnusableResult);
  SfmOptions options;
  options.colmap = "/nonexistent/colmap";
  EXPECT_EQ(TriangulateScene(input_, options, poses_).status().code(),
            StatusCode::kMissingDependency);
}

}  // namespace
}  // namespace freegs::sfm
