// SPDX-License-Identifier: BSD-3-Clause
// Photos and cameras of a new database.

#include <cstring>
#include <sqlite3.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sfm/colmap/colmap_steps.h"
#include "tests/sfm/fake_colmap.h"
#include "tests/temporary_folder.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

// A photo and its camera, as they are in the database.
struct Row {
  std::string name;
  int camera_id = 0;
  int width = 0;
  int height = 0;
  std::vector<double> params;
  bool focal_known = false;
  int model = 0;
};

std::vector<Row> ReadRows(const fs::path& path) {
  sqlite3* database = nullptr;
  EXPECT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  sqlite3_stmt* statement = nullptr;
  EXPECT_EQ(sqlite3_prepare_v2(
                database,
                "SELECT name, images.camera_id, width, height, params, "
                "prior_focal_length, model FROM images JOIN cameras ON "
                "images.camera_id = "
                "cameras.camera_id ORDER BY image_id",
                -1,
                &statement,
                nullptr),
            SQLITE_OK);
  std::vector<Row> rows;
  while (sqlite3_step(statement) == SQLITE_ROW) {
    Row row;
    row.name = reinterpret_cast<const char*>(sqlite3_column_text(statement, 0));
    row.camera_id = sqlite3_column_int(statement, 1);
    row.width = sqlite3_column_int(statement, 2);
    row.height = sqlite3_column_int(statement, 3);
    row.params.resize(sqlite3_column_bytes(statement, 4) / sizeof(double));
    std::memcpy(row.params.data(),
                sqlite3_column_blob(statement, 4),
                row.params.size() * sizeof(double));
    row.focal_known = sqlite3_column_int(statement, 5) != 0;
    row.model = sqlite3_column_int(statement, 6);
    rows.push_back(row);
  }
  sqlite3_finalize(statement);
  sqlite3_close(database);
  return rows;
}

// The photos need not exist: their sizes are known.
class RegisterPhotosTest : public testing::Test {
 protected:
  void Add(const std::string& name, int width, int height, double focal_px) {
    SfmPhoto photo;
    photo.name = name;
    photo.width = width;
    photo.height = height;
    photo.focal_px = focal_px;
    input_.photos.push_back(photo);
  }

  std::vector<Row> Register() {
    input_.photo_folder = folder_ / "photos";
    input_.work_folder = folder_ / "work";
    fs::create_directories(input_.work_folder / "logs");
    auto colmap = ColmapProgram::Find(MakeFakeColmap(folder_.path()), nullptr);
    EXPECT_TRUE(colmap.ok());
    const fs::path path = input_.work_folder / "database.db";
    const Status status = RegisterPhotos({input_, options_, *colmap, 1}, path);
    EXPECT_TRUE(status.ok()) << status.message();
    EXPECT_FALSE(fs::exists(input_.work_folder / "stand_ins"));
    return ReadRows(path);
  }

  TemporaryFolder folder_;
  SfmInput input_;
  SfmOptions options_;
};

TEST_F(RegisterPhotosTest, SharedCameraHasTheUsualFocalLength) {
  Add("b.jpg", 640, 480, 610);
  Add("a/c.PNG", 640, 480, 600);
  Add("d.tif", 640, 480, 0);
  const std::vector<Row> rows = Register();
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].name, "b.jpg");
  EXPECT_EQ(rows[1].name, "a/c.PNG");
  for (const Row& row : rows) {
    EXPECT_EQ(row.camera_id, 1);
    EXPECT_EQ(row.width, 640);
    EXPECT_EQ(row.height, 480);
    EXPECT_THAT(row.params, ElementsAre(610, 320, 240, 0, 0));
    EXPECT_TRUE(row.focal_known);
  }
}

TEST_F(RegisterPhotosTest, WhatAKilledRunLeftIsNoHindrance) {
  Add("a.jpg", 640, 480, 0);
  Add("b.jpg", 640, 480, 0);
  fs::create_directories(folder_ / "work/stand_ins/b.jpg");
  EXPECT_EQ(Register().size(), 2u);
}

TEST_F(RegisterPhotosTest, SizesHaveTheirOwnCameras) {
  Add("a.jpg", 640, 480, 0);
  Add("b.jpg", 300, 400, 350);
  options_.camera_model = "OPENCV";
  const std::vector<Row> rows = Register();
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_THAT(rows[0].params, ElementsAre(768, 768, 320, 240, 0, 0, 0, 0));
  EXPECT_FALSE(rows[0].focal_known);
  EXPECT_THAT(rows[1].params, ElementsAre(350, 350, 150, 200, 0, 0, 0, 0));
  EXPECT_TRUE(rows[1].focal_known);
}

TEST_F(RegisterPhotosTest, CamerasOfTheirOwn) {
  Add("a.jpg", 640, 480, 600);
  Add("b.jpg", 640, 480, 0);
  options_.camera = "per_image";
  options_.camera_model = "FOV";
  const std::vector<Row> rows = Register();
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_THAT(rows[0].params, ElementsAre(600, 600, 320, 240, 0.01));
  EXPECT_TRUE(rows[0].focal_known);
  EXPECT_NE(rows[1].camera_id, rows[0].camera_id);
  EXPECT_THAT(rows[1].params, ElementsAre(768, 768, 320, 240, 0.01));
  EXPECT_FALSE(rows[1].focal_known);
  EXPECT_EQ(rows[1].model, static_cast<int>(CameraModel::kFov));
}

TEST_F(RegisterPhotosTest, KnownCamerasAreTaken) {
  Add("a.jpg", 640, 480, 600);
  Add("b.jpg", 640, 480, 600);
  Camera fisheye;
  fisheye.model = CameraModel::kOpenCvFisheye;
  fisheye.width = 640;
  fisheye.height = 480;
  fisheye.params = {300, 301, 310, 230, 0.1, 0.2, 0.3, 0.4};
  input_.photos[1].camera = fisheye;
  options_.camera = "per_image";
  const std::vector<Row> rows = Register();
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].model, static_cast<int>(CameraModel::kRadial));
  EXPECT_EQ(rows[1].model, static_cast<int>(CameraModel::kOpenCvFisheye));
  EXPECT_EQ(rows[1].params, fisheye.params);
  EXPECT_TRUE(rows[1].focal_known);
}

}  // namespace
}  // namespace freegs::sfm
