// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation/ground_truth.h"

#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "core/io/files.h"
#include "core/random.h"
#include "tests/shared_data.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

const std::string kPose = "[[0,1,0,0.5],[0,0,-1,0.25],[-1,0,0,2],[0,0,0,1]]";

std::string Cameras(const std::string& pose) {
  return R"({"intrinsics": {"model": "PINHOLE", "w": 64, "h": 48, "fx": 60.5},
             "train": {"a.jpg": )" +
         pose + R"(}, "test": {"t.png": )" + kPose + "}}";
}

std::string Objects(const std::string& fields) {
  return R"({"objects": [{"id": 3, "label": "cup", )" + fields + "}]}";
}

const std::string kBox = R"("aabb": {"min": [0,0,0], "max": [1,2,3]})";

TEST(ParseCameraSet, ReadsWhatIsThere) {
  const auto cameras = ParseCameraSet(Cameras(kPose), "c.json");
  ASSERT_TRUE(cameras.ok()) << cameras.status().message();
  ASSERT_EQ(cameras->train.size(), 1u);
  ASSERT_EQ(cameras->test.size(), 1u);
  const View& view = cameras->train[0];
  EXPECT_EQ(view.name, "a.jpg");
  EXPECT_EQ(view.camera.width, 64);
  EXPECT_EQ(view.camera.fx, 60.5);
  EXPECT_EQ(view.camera.fy, 60.5);
  EXPECT_EQ(view.camera.cx, 32);
  EXPECT_EQ(view.camera.cy, 24);
  const Eigen::Vector3d point = view.cam_from_world * Eigen::Vector3d(1, 2, 3);
  EXPECT_TRUE(point.isApprox(Eigen::Vector3d(2.5, -2.75, 1)));
}

TEST(ParseCameraSet, TheNearestRotationCounts) {
  // 1.0004 times a turn with cosine 0.6 about z.
  const auto cameras = ParseCameraSet(
      Cameras("[[0.60024,-0.80032,0,0],[0.80032,0.60024,0,0],[0,0,1.0004,0]]"),
      "c.json");
  ASSERT_TRUE(cameras.ok()) << cameras.status().message();
  const Eigen::Quaterniond expected(
      Eigen::AngleAxisd(std::acos(0.6), Eigen::Vector3d::UnitZ()));
  const Rigid3d& pose = cameras->train[0].cam_from_world;
  EXPECT_NEAR(pose.rotation.angularDistance(expected), 0, 1e-9);
}

TEST(ParseCameraSet, SortsViewsAsPeopleCount) {
  const auto cameras =
      ParseCameraSet(R"({"intrinsics": {"w": 64, "h": 48, "fx": 60},
                         "test": {"p_10": )" +
                         kPose + R"(, "p_9": )" + kPose + "}}",
                     "c.json");
  ASSERT_TRUE(cameras.ok()) << cameras.status().message();
  ASSERT_EQ(cameras->test.size(), 2u);
  EXPECT_EQ(cameras->test[0].name, "p_9");
  EXPECT_EQ(cameras->test[1].name, "p_10");
}

TEST(ParseCameraSet, NamesFileAndEntryOfAFault) {
  const auto bad = ParseCameraSet(Cameras("[[1,0,0,0],[0,1,0,0]]"), "c.json");
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(bad.status().code(), StatusCode::kBadInput);
  EXPECT_NE(bad.status().message().find("c.json"), std::string::npos);
  EXPECT_NE(bad.status().message().find("a.jpg"), std::string::npos);
}

TEST(ParseCameraSet, RefusesMatricesThatAreNotPoses) {
  for (const char* pose : {
           "[]",
           "7",
           "null",
           "\"text\"",
           "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0]]",
           "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,2]]",
           "[[1,0,0,0],[0,1,0,0],[0,0,\"x\",0],[0,0,0,1]]",
           "[[2,0,0,0],[0,2,0,0],[0,0,2,0],[0,0,0,1]]",
           "[[-1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]",
           "[[1,0,0,1e400],[0,1,0,0],[0,0,1,0],[0,0,0,1]]",
           "[[1,0,0,0],[0,1,0,0],[0,0,1,-1e30],[0,0,0,1]]",
           "[[0,0,0,0],[0,0,0,0],[0,0,0,0],[0,0,0,1]]",
       }) {
    EXPECT_FALSE(ParseCameraSet(Cameras(pose), "c").ok()) << pose;
  }
}

TEST(ParseCameraSet, RefusesBadIntrinsics) {
  for (const char* intrinsics : {
           "{}",
           "[]",
           R"({"w": 64, "h": 48})",
           R"({"w": 0, "h": 48, "fx": 60})",
           R"({"w": 64.5, "h": 48, "fx": 60})",
           R"({"w": 1e9, "h": 48, "fx": 60})",
           R"({"w": 64, "h": 48, "fx": -60})",
           R"({"w": 64, "h": 48, "fx": "60"})",
           R"({"w": 64, "h": 48, "fx": 60, "cx": null})",
           R"({"w": 64, "h": 48, "fx": 1e-320})",
           R"({"w": 64, "h": 48, "fx": 0.5})",
           R"({"w": 64, "h": 48, "fx": 60, "fy": 1e30})",
           R"({"w": 64, "h": 48, "fx": 60, "cx": 1e10})",
           R"({"w": 64, "h": 48, "fx": 60, "cy": -1e10})",
       }) {
    const std::string text =
        std::string(R"({"train": {}, "intrinsics": )") + intrinsics + "}";
    EXPECT_FALSE(ParseCameraSet(text, "c").ok()) << text;
  }
}

TEST(ParseCameraSet, RefusesNamesThatLeaveTheFolder) {
  for (const char* name : {"../a.jpg", "/etc/passwd", "", "x/../../a", "a/"}) {
    const std::string text =
        R"({"intrinsics": {"w": 64, "h": 48, "fx": 60}, "test": {")" +
        std::string(name) + "\": " + kPose + "}}";
    EXPECT_FALSE(ParseCameraSet(text, "c").ok()) << name;
  }
}

TEST(ParseCameraSet, SurvivesTruncationAndNoise) {
  const std::string good = Cameras(kPose);
  for (size_t length = 0; length + 1 < good.size(); ++length) {
    EXPECT_FALSE(ParseCameraSet(good.substr(0, length), "c").ok());
  }
  for (uint64_t i = 0; i < 500; ++i) {
    std::string noisy = good;
    noisy[RandomIndex(1, i, 0, noisy.size())] =
        static_cast<char>(RandomBits(1, i, 1));
    (void)ParseCameraSet(noisy, "c").ok();  // Any answer, but an answer.
  }
  EXPECT_FALSE(ParseCameraSet(std::string(100000, '['), "c").ok());
}

TEST(ParseTrueObjects, ReadsWhatIsThere) {
  const auto objects = ParseTrueObjects(
      R"({"objects": [
        {"id": 7, "label": "b", "aabb": {"min": [0,0,0], "max": [1,1,1]},
         "obb": {"center": 5}},
        {"id": 2, "label": "a", "aabb": {"min": [0,0,0], "max": [1,2,3]}}]})",
      "o.json");
  ASSERT_TRUE(objects.ok()) << objects.status().message();
  ASSERT_EQ(objects->size(), 2u);
  EXPECT_EQ((*objects)[0].id, 2);
  EXPECT_EQ((*objects)[0].label, "a");
  EXPECT_EQ((*objects)[0].aabb->max, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ((*objects)[1].label, "b");
}

TEST(ParseTrueObjects, RefusesMalformedObjects) {
  EXPECT_TRUE(ParseTrueObjects(Objects(kBox), "o").ok());
  for (const std::string& text : {
           std::string("[]"),
           std::string("{}"),
           std::string(R"({"objects": {}})"),
           std::string(R"({"objects": [5]})"),
           std::string(R"({"objects": [{"id": 0, "label": "x", )") + kBox +
               "}]}",
           std::string(R"({"objects": [{"id": 70000, "label": "x", )") + kBox +
               "}]}",
           std::string(R"({"objects": [{"id": 1, "label": 5, )") + kBox + "}]}",
           Objects(R"("aabb": null)"),
           Objects(R"("aabb": {"min": [0,0], "max": [1,2,3]})"),
           Objects(R"("aabb": {"min": [2,0,0], "max": [1,2,3]})"),
           Objects(kBox + R"(}, {"id": 3, "label": "again", )" + kBox),
       }) {
    EXPECT_FALSE(ParseTrueObjects(text, "o").ok()) << text;
  }
}

TEST(ReadGroundTruth, TakesTheSceneFolderOrItsGtFolder) {
  const TemporaryFolder temporary;
  const fs::path scene = temporary / "scene";
  EXPECT_EQ(ReadGroundTruth(scene).status().code(), StatusCode::kBadInput);
  ASSERT_TRUE(CreateFolders(scene / "gt").ok());
  ASSERT_TRUE(WriteFileAtomic(scene / "gt/cameras.json", Cameras(kPose)).ok());
  EXPECT_TRUE(ReadGroundTruth(scene)->photos.empty());
  EXPECT_TRUE(ReadGroundTruth(scene)->masks.empty());
  for (const char* file : {"test/images/t.png", "gt/instance/t.png"}) {
    ASSERT_TRUE(CreateFolders((scene / file).parent_path()).ok());
    ASSERT_TRUE(WriteFileAtomic(scene / file, "not looked into").ok());
  }
  for (const fs::path& folder : {scene, scene / "gt", scene / "gt" / ""}) {
    const auto truth = ReadGroundTruth(folder);
    ASSERT_TRUE(truth.ok()) << truth.status().message();
    EXPECT_TRUE(truth->objects.empty());
    EXPECT_EQ(fs::weakly_canonical(truth->photos.at("t.png")),
              fs::weakly_canonical(scene / "test/images/t.png"));
    ASSERT_EQ(truth->masks.at("t.png").size(), 1u);
    EXPECT_EQ(fs::weakly_canonical(truth->masks.at("t.png")[0].path),
              fs::weakly_canonical(scene / "gt/instance/t.png"));
    EXPECT_TRUE(truth->complete);
  }
  ASSERT_TRUE(WriteFileAtomic(scene / "gt/objects.json", "{").ok());
  EXPECT_FALSE(ReadGroundTruth(scene).ok());
}

TEST(ReadGroundTruth, ReadsTheSharedTabletop) {
  const fs::path scene = SharedData("tabletop");
  if (scene.empty()) GTEST_SKIP() << "FREEGS_SHARED_DATA has no tabletop";
  const auto truth = ReadGroundTruth(scene);
  ASSERT_TRUE(truth.ok()) << truth.status().message();
  EXPECT_EQ(truth->cameras.train.size(), 60u);
  EXPECT_EQ(truth->cameras.test.size(), 8u);
  EXPECT_EQ(truth->objects.size(), 9u);
  EXPECT_EQ(truth->objects[3].label, "red apple");
  EXPECT_TRUE(truth->objects[3].aabb.has_value());
}

}  // namespace
}  // namespace freegs::stages
