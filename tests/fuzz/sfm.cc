// SPDX-License-Identifier: BSD-3-Clause
// Cameras, poses and points of COLMAP and others.

#include <sqlite3.h>

#include "sfm/import/import_model.h"
#include "sfm/matching/match_database.h"
#include "sfm/scene/model_io.h"
#include "sfm/scene/model_io_binary.h"
#include "sfm/scene/model_io_text.h"
#include "tests/fuzz/reader.h"

namespace freegs::fuzz {
namespace {

namespace fs = std::filesystem;

sfm::Reconstruction SmallScene() {
  sfm::Reconstruction scene;
  scene.cameras = {
      {1, sfm::CameraModel::kPinhole, 64, 48, {60, 60, 32, 24}},
      {2, sfm::CameraModel::kRadial, 64, 48, {60, 32, 24, 0.1, 0}}};
  for (uint32_t id = 1; id <= 2; ++id) {
    sfm::PosedImage image;
    image.id = id;
    image.camera_id = id;
    image.name = id == 1 ? "a.jpg" : "b c.jpg";
    image.cam_from_world.translation.x() = id;
    image.points2d = {{{3, 4}, 7}, {{5, 6}, sfm::kNoPoint3D}};
    scene.images.push_back(image);
  }
  sfm::Point3D point;
  point.id = 7;
  point.xyz = {0, 0, 5};
  point.track = {{1, 0}, {2, 0}};
  scene.points3d.push_back(point);
  return scene;
}

std::vector<sfm::SfmPhoto> SmallPhotos() {
  std::vector<sfm::SfmPhoto> photos(2);
  photos[0].name = "a.jpg";
  photos[1].name = "b c.jpg";
  for (sfm::SfmPhoto& photo : photos) {
    photo.width = 64;
    photo.height = 48;
  }
  return photos;
}

// Imports what lies at `path` as the program does.
void Import(const fs::path& path) {
  const auto source = sfm::FindImportSource(path);
  if (!source.ok()) return;
  sfm::ImportOptions options;
  options.random_points = 20;
  const auto imported = sfm::ImportModel(*source, SmallPhotos(), options);
  if (!imported.ok()) return;
  Require(sfm::CheckReconstruction(imported->model).ok());
  Require(sfm::WriteModel(Scratch() / "out", imported->model).ok());
  Require(sfm::ReadModel(Scratch() / "out").ok());
}

std::vector<FolderFile> BinaryFiles() {
  const sfm::Reconstruction scene = SmallScene();
  return {{"cameras.bin", sfm::CamerasToBinary(scene.cameras)},
          {"images.bin", sfm::ImagesToBinary(scene.images)},
          {"points3D.bin", sfm::PointsToBinary(scene.points3d)}};
}

std::vector<FolderFile> TextFiles() {
  const sfm::Reconstruction scene = SmallScene();
  return {{"cameras.txt", sfm::CamerasToText(scene.cameras)},
          {"images.txt", sfm::ImagesToText(scene.images)},
          {"points3D.txt", sfm::PointsToText(scene.points3d)}};
}

// Everything that is read from a database, and what is changed in one.
void UseDatabase(const fs::path& path) {
  auto database = sfm::MatchDatabase::Open(path);
  if (!database.ok()) return;
  const auto photos = database->Photos();
  for (uint32_t id = 0; id < 4; ++id) {
    (void)database->Descriptors(id);
    (void)database->FeatureScales(id);
  }
  (void)database->VerifiedPairs();
  (void)database->ComparedPairs();
  (void)database->ForEachVerifiedPair(
      [](uint32_t first,
         uint32_t second,
         std::span<const sfm::FeatureMatch> matches) {
        Require(first < second && !matches.empty());
      });
  (void)database->RemoveVerifiedPairs({{1, 2}});
  (void)database->ClearMatchesAndDescriptors();
}

std::string SmallDatabase() {
  const fs::path path = Scratch() / "seed.db";
  fs::remove(path);
  sqlite3* database = nullptr;
  Require(sqlite3_open(path.c_str(), &database) == SQLITE_OK);
  const std::string pair = std::to_string(int64_t{1} * 2147483647 + 2);
  const std::string sql =
      "PRAGMA page_size = 512;"
      "CREATE TABLE images(image_id INTEGER PRIMARY KEY, name TEXT UNIQUE);"
      "CREATE TABLE keypoints(image_id INTEGER PRIMARY KEY, rows INTEGER, "
      "cols INTEGER, data BLOB);"
      "CREATE TABLE descriptors(image_id INTEGER PRIMARY KEY, rows INTEGER, "
      "cols INTEGER, data BLOB);"
      "CREATE TABLE matches(pair_id INTEGER PRIMARY KEY, rows INTEGER, "
      "cols INTEGER, data BLOB);"
      "CREATE TABLE two_view_geometries(pair_id INTEGER PRIMARY KEY, rows "
      "INTEGER, cols INTEGER, data BLOB, config INTEGER, F BLOB, E BLOB, "
      "H BLOB);"
      "INSERT INTO images VALUES(1,'a.jpg'),(2,'b c.jpg');"
      "INSERT INTO keypoints VALUES(1,2,4,zeroblob(32)),(2,1,6,zeroblob(24));"
      "INSERT INTO descriptors VALUES(1,2,128,zeroblob(256));"
      "INSERT INTO matches VALUES(" +
      pair +
      ",2,2,zeroblob(16));"
      "INSERT INTO two_view_geometries VALUES(" +
      pair + ",2,2,zeroblob(16),3,NULL,NULL,zeroblob(72));";
  Require(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr) ==
          SQLITE_OK);
  sqlite3_close(database);
  return ReadText(path);
}

}  // namespace

Reader ColmapBinary() {
  return {[](std::string_view bytes) {
            static const std::vector<FolderFile> files = BinaryFiles();
            WriteWithOneReplaced(Scratch() / "binary", files, bytes);
            Import(Scratch() / "binary");
          },
          [] { return SeedsOfFolder(BinaryFiles()); }};
}

Reader ColmapText() {
  return {[](std::string_view bytes) {
            static const std::vector<FolderFile> files = TextFiles();
            WriteWithOneReplaced(Scratch() / "text", files, bytes);
            Import(Scratch() / "text");
          },
          [] { return SeedsOfFolder(TextFiles()); }};
}

Reader ColmapDatabase() {
  return {[](std::string_view bytes) {
            sfm::RemoveDatabase(Scratch() / "a.db");
            WriteText(Scratch() / "a.db", bytes);
            UseDatabase(Scratch() / "a.db");
          },
          [] { return std::vector<std::string>{SmallDatabase()}; }};
}

Reader Transforms() {
  return {[](std::string_view bytes) {
            WriteText(Scratch() / "transforms.json", bytes);
            Import(Scratch() / "transforms.json");
          },
          [] {
            return std::vector<std::string>{
                R"({"camera_angle_x": 0.7, "fl_x": 60, "cx": 32.5, "cy": 24,
"w": 64, "h": 48, "k1": 0.05, "k2": -0.08, "p1": 0.001, "p2": 0.002,
"frames": [{"file_path": "images/a.jpg", "transform_matrix":
[[1,0,0,1],[0,0,-1,2],[0,1,0,3],[0,0,0,1]]},
{"file_path": "images/b c.jpg", "fl_x": 50,
"transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,5]]}]})",
                R"({"camera_model": "OPENCV_FISHEYE", "fl_x": 60, "fl_y": 60,
"k1": 0.1, "k2": 0, "k3": 0, "k4": 0.01, "frames": [{"file_path": "./a",
"transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,5],[0,0,0,1]]}]})"};
          }};
}

}  // namespace freegs::fuzz
