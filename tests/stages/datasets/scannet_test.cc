// SPDX-License-Identifier: BSD-3-Clause

#include "stages/datasets/scannet.h"

#include <cmath>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/files.h"
#include "core/random.h"
#include "stages/datasets/layout.h"
#include "stages/datasets/scannet_mesh.h"
#include "stages/datasets/scannet_objects.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using testing::HasSubstr;

// A chair of two segments, a table of one, and a wall.
const std::string kPly =
    "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\n"
    "property float y\nproperty float z\nproperty uchar red\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0 9\n1 2 0 9\n1 1 3 9\n5 5 5 9\n6 7 8 9\n-9 -9 -9 9\n3 0 1 2\n";
const std::string kSegments =
    R"({"params": {}, "sceneId": "s", "segIndices": [4, 4, 8, 15, 15, 16]})";
const std::string kGroups = R"({"sceneId": "s", "segGroups": [
    {"id": 1, "objectId": 1, "label": "table", "segments": [15]},
    {"id": 0, "objectId": 0, "label": "chair", "segments": [4, 8]},
    {"id": 2, "objectId": 2, "label": "wall", "segments": [16]},
    {"id": 3, "objectId": 3, "label": "ghost", "segments": [99]}]})";
// A quarter turn about z, and a step along x.
const std::string kFacts =
    "colorWidth = 1296\naxisAlignment = 0 -1 0 10 1 0 0 0 0 0 1 0 0 0 0 1 \n"
    "numColorFrames = 3\n";

class ScannetTest : public testing::Test {
 protected:
  void SetUp() override {
    Write("scene0060_00_vh_clean_2.ply", kPly);
    Write("scene0060_00_vh_clean_2.0.010000.segs.json", kSegments);
    Write("scene0060_00.aggregation.json", kGroups);
    Write("scene0060_00_vh_clean.aggregation.json", "of the fine mesh");
    Write("scene0060_00.txt", kFacts);
    Write("pose/0.txt", "1 0 0 2\n0 1 0 3\n0 0 1 4\n0 0 0 1\n");
    Write("pose/20.txt", "1 0 0 5\n0 1 0 3\n0 0 1 4\n0 0 0 1\n");
    Write("pose/40.txt",
          "-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n"
          "-inf -inf -inf -inf\n");
  }

  void Write(const std::string& name, const std::string& text) {
    const fs::path path = folder_ / name;
    ASSERT_TRUE(CreateFolders(path.parent_path()).ok());
    ASSERT_TRUE(WriteFileAtomic(path, text).ok());
  }

  std::string Fault() {
    const auto truth = ReadScannet(folder_.path());
    EXPECT_EQ(truth.status().code(), StatusCode::kBadInput);
    return truth.status().message();
  }

  TemporaryFolder folder_;
};

TEST_F(ScannetTest, ReadsBoxesAndPosesInTheAlignedFrame) {
  EXPECT_EQ(DetectLayout(folder_.path()), "scannet");
  const auto truth = ReadTruth(folder_.path(), "auto");
  ASSERT_TRUE(truth.ok()) << truth.status().message();
  ASSERT_EQ(truth->objects.size(), 2u);
  EXPECT_EQ(truth->objects[0].id, 1);
  EXPECT_EQ(truth->objects[0].label, "chair");
  // (x, y, z) goes to (10 - y, x, z).
  EXPECT_TRUE(truth->objects[0].aabb->min.isApprox(Vector3d(8, 0, 0)));
  EXPECT_TRUE(truth->objects[0].aabb->max.isApprox(Vector3d(10, 1, 3)));
  EXPECT_EQ(truth->objects[1].label, "table");
  EXPECT_TRUE(truth->objects[1].aabb->min.isApprox(Vector3d(3, 5, 5)));
  ASSERT_EQ(truth->cameras.train.size(), 2u);
  EXPECT_EQ(truth->cameras.train[0].name, "0.jpg");
  EXPECT_TRUE(CameraCentre(truth->cameras.train[0].cam_from_world)
                  .isApprox(Vector3d(7, 2, 4)));
  EXPECT_TRUE(truth->cameras.test.empty());
  EXPECT_TRUE(truth->masks.empty());
}

TEST_F(ScannetTest, TheLabelledMeshServesAsWellAndAlignmentMayLack) {
  fs::rename(folder_ / "scene0060_00_vh_clean_2.ply",
             folder_ / "scene0060_00_vh_clean_2.labels.ply");
  fs::remove(folder_ / "scene0060_00.txt");
  const auto truth = ReadScannet(folder_.path());
  ASSERT_TRUE(truth.ok()) << truth.status().message();
  EXPECT_TRUE(truth->objects[0].aabb->max.isApprox(Vector3d(1, 2, 3)));
}

TEST_F(ScannetTest, TheNearestRotationOfAPoseCounts) {
  // 1.004 times a turn with cosine 0.6 about z, without the scan's alignment.
  Write("pose/0.txt",
        "0.6024 -0.8032 0 0\n0.8032 0.6024 0 0\n0 0 1.004 0\n0 0 0 1\n");
  fs::remove(folder_ / "scene0060_00.txt");
  const auto truth = ReadScannet(folder_.path());
  ASSERT_TRUE(truth.ok()) << truth.status().message();
  const Eigen::Quaterniond expected(
      Eigen::AngleAxisd(-std::acos(0.6), Vector3d::UnitZ()));
  const Rigid3d& pose = truth->cameras.train[0].cam_from_world;
  EXPECT_NEAR(pose.rotation.angularDistance(expected), 0, 1e-9);
}

TEST_F(ScannetTest, SaysWhatIsMissingOrDoesNotFit) {
  Write("pose/60.txt", "1 0 0");
  EXPECT_THAT(Fault(), HasSubstr("60.txt: must be 16 numbers"));
  Write("pose/60.txt", "2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1");
  EXPECT_THAT(Fault(), HasSubstr("60.txt: not a rotation matrix"));
  fs::remove_all(folder_ / "pose");
  EXPECT_THAT(Fault(), HasSubstr("no frame with a pose"));
  Write("scene0060_00_vh_clean_2.0.010000.segs.json",
        R"({"segIndices": [1, 2]})");
  EXPECT_THAT(Fault(), HasSubstr("do not belong together"));
  Write("scene0060_00.txt", "axisAlignment = 1 2 3");
  EXPECT_THAT(Fault(), HasSubstr("axisAlignment"));
  for (const char* file : {"scene0060_00_vh_clean_2.ply",
                           "scene0060_00_vh_clean_2.0.010000.segs.json",
                           "scene0060_00.aggregation.json"}) {
    fs::remove(folder_ / file);
    if (std::string(file) != "scene0060_00.aggregation.json") {
      EXPECT_THAT(Fault(), HasSubstr("belongs to the scan's download"));
    }
  }
  EXPECT_FALSE(ReadScannet(folder_.path()).ok());
}

TEST_F(ScannetTest, WithoutAnnotationPiecesOfOneLabelAreObjects) {
  // A strip of 60 chair vertices, one of 60 table vertices that hangs on it,
  // and a chair that is too small.
  std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 123\nproperty float x\n"
      "property float y\nproperty float z\nproperty ushort label\n"
      "element face 119\nproperty list uchar int vertex_indices\nend_header\n";
  for (int i = 0; i < 120; ++i) {
    ply += std::to_string(i) + " " + std::to_string(i % 2) + " 0 " +
           (i < 60 ? "5" : "7") + "\n";
  }
  ply += "0 0 9 5\n0 1 9 5\n1 0 9 5\n";
  for (int i = 0; i + 2 < 120; ++i) {
    ply += "3 " + std::to_string(i) + " " + std::to_string(i + 1) + " " +
           std::to_string(i + 2) + "\n";
  }
  ply += "3 120 121 122\n";
  fs::remove(folder_ / "scene0060_00.aggregation.json");
  fs::remove(folder_ / "scene0060_00_vh_clean.aggregation.json");
  fs::remove(folder_ / "scene0060_00.txt");
  Write("scene0060_00_vh_clean_2.labels.ply", ply);
  EXPECT_EQ(DetectLayout(folder_.path()), "scannet");
  const auto truth = ReadScannet(folder_.path());
  ASSERT_TRUE(truth.ok()) << truth.status().message();
  ASSERT_EQ(truth->objects.size(), 2u);
  EXPECT_EQ(truth->objects[0].label, "chair");
  EXPECT_TRUE(truth->objects[0].aabb->max.isApprox(Vector3d(59, 1, 0)));
  EXPECT_EQ(truth->objects[1].label, "table");
  EXPECT_TRUE(truth->objects[1].aabb->min.isApprox(Vector3d(60, 0, 0)));
  Write("scene0060_00_vh_clean_2.labels.ply", kPly);
  EXPECT_THAT(Fault(), HasSubstr("without labels"));
}

TEST(ScannetObjects, SurviveTruncationAndNoise) {
  for (size_t length = 0; length < kPly.size(); ++length) {
    const auto mesh = ParseScannetMesh(kPly.substr(0, length), "p");
    // Only the last digit and the line's end can be spared.
    EXPECT_TRUE(length + 2 >= kPly.size() || !mesh.ok()) << length;
  }
  for (size_t length = 0; length + 1 < kGroups.size(); ++length) {
    EXPECT_FALSE(ParseScannetGroups(kGroups.substr(0, length), "g").ok());
  }
  for (uint64_t i = 0; i < 500; ++i) {
    for (std::string text : {kPly, kSegments, kGroups, kFacts}) {
      text[RandomIndex(1, i, 0, text.size())] =
          static_cast<char>(RandomBits(1, i, 1));
      (void)ParseScannetMesh(text, "p").ok();  // Any answer will do.
      (void)ParseScannetSegments(text, "s").ok();
      (void)ParseScannetGroups(text, "g").ok();
      (void)ParseScannetAlignment(text, "a").ok();
    }
  }
}

// If each repetition counted, the time would grow with the number of vertices
// times that of repetitions.
TEST(ScannetObjects, SegmentsCountOnceForEachGroup) {
  const auto groups = ParseScannetGroups(
      R"({"segGroups": [
          {"objectId": 0, "label": "a", "segments": [4, 7, 4, 4]},
          {"objectId": 1, "label": "b", "segments": [4]}]})",
      "g");
  ASSERT_TRUE(groups.ok()) << groups.status().message();
  EXPECT_THAT((*groups)[0].segments, testing::ElementsAre(4, 7));
  const auto objects = ScannetBoxes({{0, 0, 0}, {1, 2, 3}, {5, 0, 0}},
                                    {4, 4, 7},
                                    *groups,
                                    Eigen::Matrix4d::Identity());
  ASSERT_TRUE(objects.ok()) << objects.status().message();
  ASSERT_EQ(objects->size(), 2u);
  EXPECT_EQ((*objects)[0].aabb->max, Eigen::Vector3d(5, 2, 3));
  EXPECT_EQ((*objects)[1].aabb->max, Eigen::Vector3d(1, 2, 3));
}

TEST(ScannetObjects, RefuseWhatIsMalformed) {
  const std::string header = "ply\nformat ascii 1.0\n";
  for (const std::string& ply :
       {std::string("not a ply"),
        header + "end_header\n",
        header + "element vertex 99999999999999\nproperty float x\n"
                 "property float y\nproperty float z\nend_header\n1 2 3\n",
        header + "element vertex 1\nproperty float x\nproperty float y\n"
                 "end_header\n1 2\n",
        header + "element vertex 1\nproperty float x\nproperty float y\n"
                 "property float z\nelement face 1\nproperty list uchar int "
                 "vertex_indices\nend_header\n1 2 3\n3 0 0 1\n",
        header + "element vertex 1\nproperty float x\nproperty float y\n"
                 "property float z\nend_header\n1 nan 2\n",
        // The corners would be checked against the first one.
        header + "element vertex 3\nproperty float x\nproperty float y\n"
                 "property float z\nelement face 1\nproperty list uchar int "
                 "vertex_indices\nelement vertex 1\nproperty float x\n"
                 "property float y\nproperty float z\nend_header\n"
                 "1 2 3\n1 2 4\n1 2 5\n3 0 1 2\n6 7 8\n"}) {
    const auto mesh = ParseScannetMesh(ply, "m.ply");
    EXPECT_EQ(mesh.status().code(), StatusCode::kBadInput);
    EXPECT_THAT(mesh.status().message(), HasSubstr("m.ply"));
  }
  for (const char* text : {"[]",
                           "{}",
                           R"({"segIndices": 5})",
                           R"({"segIndices": ["x"]})",
                           R"({"segIndices": [1.5]})"}) {
    EXPECT_FALSE(ParseScannetSegments(text, "s").ok()) << text;
  }
  for (const char* group :
       {"5",
        R"({"objectId": 0, "label": "x"})",
        R"({"objectId": -1, "label": "x", "segments": []})",
        R"({"objectId": 65535, "label": "x", "segments": []})",
        R"({"objectId": 0, "label": 7, "segments": []})",
        R"({"objectId": 0, "label": "x", "segments": [null]})",
        R"({"objectId": 0, "label": "x", "segments": []},
           {"objectId": 0, "label": "y", "segments": []})"}) {
    EXPECT_FALSE(ParseScannetGroups(
                     std::string(R"({"segGroups": [)") + group + "]}", "g")
                     .ok())
        << group;
  }
  for (const char* text : {"axisAlignment = ",
                           "axisAlignment 1 0 0 0",
                           "axisAlignment = 2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1",
                           "axisAlignment = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1"}) {
    EXPECT_FALSE(ParseScannetAlignment(text, "a").ok()) << text;
  }
  EXPECT_TRUE(ParseScannetAlignment("", "a")->isIdentity());
}

}  // namespace
}  // namespace freegs::stages
