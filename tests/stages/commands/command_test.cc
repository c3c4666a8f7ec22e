// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/command.h"

#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/stage_record.h"
#include "pipeline/workspace.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class OutputPlaceTest : public ::testing::Test {
 protected:
  OutputPlaceTest() {
    fs::create_directories(folder_ / "photos");
    for (const char* name : {"a", "b"}) {
      fs::create_directories(folder_ / name / "reconstruct");
      pipeline::WorkspaceInfo info;
      info.images = folder_ / "photos";
      EXPECT_TRUE(pipeline::WriteWorkspaceInfo(folder_ / name, info).ok());
      EXPECT_TRUE(pipeline::WriteStageRecord(folder_ / name / "reconstruct",
                                             pipeline::StageRecord())
                      .ok());
    }
  }

  void ExpectRefused(const std::string& place, const std::string& why) const {
    const Status status = CheckOutputPlace(folder_ / "a", folder_ / place);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument) << place;
    EXPECT_THAT(status.message(), HasSubstr(why)) << place;
  }

  TemporaryFolder folder_;
};

TEST_F(OutputPlaceTest, WhatTheProgramOrTheUserHasThereIsKept) {
  ExpectRefused("a/reconstruct/x.ply", "the folder of stage reconstruct");
  ExpectRefused("a/bootstrap", "the folder of stage bootstrap");
  ExpectRefused("photos", "holds the photos");
  ExpectRefused("photos/masks/x.png", "holds the photos");
  ExpectRefused("a/../photos/1.jpg", "holds the photos");
  ExpectRefused("a/workspace.json", "belongs to a workspace");
  ExpectRefused("b/workspace.json", "belongs to a workspace");
  ExpectRefused("b/reconstruct/point_cloud.ply", "which a stage made");
  ExpectRefused("b/reconstruct/new/folder/x.ply", "which a stage made");
}

TEST_F(OutputPlaceTest, WhatOptionsNameIsKept) {
  pipeline::WorkspaceInfo info;
  info.settings["sfm.import"] = (folder_ / "model").string();
  info.settings["no.longer"] = folder_.path().string();
  ASSERT_TRUE(pipeline::WriteWorkspaceInfo(folder_ / "a", info).ok());
  folder_.Write("a/config.ini",
                "[ingest]\nmasks = ../d/masks\nuse_masks = true\n"
                "[reconstruct]\nimport = start.ply\n");
  ExpectRefused("model", "(sfm.import");
  ExpectRefused("d/masks", "(ingest.masks");
  ExpectRefused("d/masks/1.png", "(ingest.masks");
  ExpectRefused("a/start.ply", "(reconstruct.import");
  for (const char* place : {"d/overlay", "a/true", "a/x.ply"}) {
    EXPECT_TRUE(CheckOutputPlace(folder_ / "a", folder_ / place).ok()) << place;
  }
  folder_.Write("a/config.ini", "[ingest]\nmask = ../d/masks\n");
  ExpectRefused("d/masks", "config.ini");
}

// Only what is imported from the folder of a scene is kept, and not all that
// lies beside it, such as the workspace.
TEST_F(OutputPlaceTest, WhatIsImportedIsKept) {
  const auto set_import = [&](const std::string& path) {
    folder_.Write("a/config.ini", "[sfm]\nimport = ../" + path + "\n");
  };
  const auto expect_free = [&](const std::vector<std::string>& places) {
    for (const std::string& place : places) {
      EXPECT_TRUE(CheckOutputPlace(folder_ / "a", folder_ / place).ok())
          << place;
    }
  };
  folder_.Write("transforms.json", "{}");
  set_import(".");
  ExpectRefused("transforms.json", "(sfm.import = ");
  // A COLMAP model in one of these would be read in place of the other.
  for (const char* place : {".", "sparse/0", "sparse", "0"}) {
    ExpectRefused(place, "(sfm.import = ");
  }
  expect_free({"a/out", "x.ply", "renders"});

  for (const char* folder : {"scene/sparse/0", "model"}) {
    for (const char* file : {"/cameras.txt", "/images.txt", "/points3D.txt"}) {
      folder_.Write(std::string(folder) + file, "");
    }
  }
  set_import("scene");
  ExpectRefused("scene", "(sfm.import = ");
  ExpectRefused("scene/sparse/0", "(sfm.import = ");
  ExpectRefused("scene/sparse/0/points3D.txt", "(sfm.import = ");
  expect_free({"a/out", "scene/renders", "scene/sparse/1", "transforms.json"});
  // One file stands for its folder.
  set_import("model/cameras.txt");
  ExpectRefused("model", "(sfm.import = ");
  ExpectRefused("model/images.txt", "(sfm.import = ");
  expect_free({"a/out", "model/renders"});
}

TEST_F(OutputPlaceTest, AWorkspaceInAFolderOfMasksIsFree) {
  folder_.Write("a/config.ini", "[ingest]\nmasks = ..\n");
  ExpectRefused("x.png", "(ingest.masks");
  EXPECT_TRUE(CheckOutputPlace(folder_ / "a", folder_ / "a" / "x.png").ok());
}

TEST_F(OutputPlaceTest, OtherPlacesAreFree) {
  EXPECT_TRUE(CheckOutputPlace(folder_ / "a", fs::path()).ok());
  for (const char* place :
       {"x.ply", "a/renders", "a/boxes.json", "b/renders/x", "photos2/1.jpg"}) {
    EXPECT_TRUE(CheckOutputPlace(folder_ / "a", folder_ / place).ok()) << place;
  }
}

TEST_F(OutputPlaceTest, StagesAreKeptWithoutAWorkspaceToo) {
  EXPECT_FALSE(CheckOutputPlace(folder_ / "b" / "reconstruct" / "x.png").ok());
  EXPECT_TRUE(CheckOutputPlace(folder_ / "photos" / "x.png").ok());
}

TEST_F(OutputPlaceTest, AFilmIsKept) {
  pipeline::WorkspaceInfo info;
  info.images = folder_ / "film.mp4";
  ASSERT_TRUE(pipeline::WriteWorkspaceInfo(folder_ / "a", info).ok());
  ExpectRefused("film.mp4", "holds the photos");
}

}  // namespace
}  // namespace freegs::stages
