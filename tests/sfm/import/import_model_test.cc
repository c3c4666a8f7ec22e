// SPDX-License-Identifier: BSD-3-Clause
// Imported poses: where they are found, and how they fit the photos.

#include "sfm/import/import_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sfm/scene/model_io.h"
#include "tests/sfm/synthetic_model.h"
#include "tests/shared_data.h"
#include "tests/temporary_folder.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<SfmPhoto> Photos(int count, int width = 640, int height = 480) {
  std::vector<SfmPhoto> photos;
  for (int i = 0; i < count; ++i) {
    SfmPhoto photo;
    photo.name = PhotoName(i);
    photo.width = width;
    photo.height = height;
    photos.push_back(photo);
  }
  return photos;
}

StatusOr<ImportedModel> Import(const fs::path& path,
                               const std::vector<SfmPhoto>& photos) {
  FREEGS_ASSIGN_OR_RETURN(const ImportSource source, FindImportSource(path));
  return ImportModel(source, photos, {100, 0});
}

TEST(FindImportSource, ColmapFoldersAndParents) {
  for (const char* below : {".", "sparse/0", "sparse", "0"}) {
    for (const ModelFormat format :
         {ModelFormat::kBinary, ModelFormat::kText}) {
      const TemporaryFolder folder;
      ASSERT_TRUE(
          WriteModel(folder.path() / below, SyntheticModel(3, 2), format).ok());
      const auto source = FindImportSource(folder.path());
      ASSERT_TRUE(source.ok()) << source.status().message();
      EXPECT_TRUE(fs::equivalent(source->colmap_model, folder.path() / below));
      EXPECT_EQ(source->Files().size(), 3u);
      for (const fs::path& file : source->Files()) EXPECT_TRUE(exists(file));
    }
  }
}

TEST(FindImportSource, TransformsFiles) {
  const TemporaryFolder folder;
  WriteText(folder / "transforms_train.json", "{}");
  auto source = FindImportSource(folder.path());
  ASSERT_TRUE(source.ok());
  EXPECT_EQ(source->transforms, folder / "transforms_train.json");
  EXPECT_TRUE(source->holdout_transforms.empty());
  WriteText(folder / "transforms_val.json", "{}");
  WriteText(folder / "transforms_test.json", "{}");
  source = FindImportSource(folder / "transforms_train.json");
  ASSERT_TRUE(source.ok());
  EXPECT_THAT(source->holdout_transforms,
              ElementsAre(folder / "transforms_test.json",
                          folder / "transforms_val.json"));
  EXPECT_EQ(source->Files().size(), 3u);
  WriteText(folder / "transforms.json", "{}");
  EXPECT_EQ(FindImportSource(folder.path())->transforms,
            folder / "transforms.json");
}

TEST(FindImportSource, NothingThere) {
  const TemporaryFolder folder;
  const auto empty = FindImportSource(folder.path());
  ASSERT_FALSE(empty.ok());
  EXPECT_THAT(empty.status().message(), HasSubstr("transforms.json"));
  EXPECT_FALSE(FindImportSource(folder / "missing").ok());
  WriteText(folder / "a.txt", "");
  EXPECT_FALSE(FindImportSource(folder / "a.txt").ok());
}

TEST(ImportModel, ColmapModelUnderThePhotosNames) {
  const TemporaryFolder folder;
  Reconstruction model = SyntheticModel(5, 20);
  for (PosedImage& image : model.images) image.name = "images/" + image.name;
  model.images[4].name = "images/other.jpg";
  std::swap(model.images[0], model.images[2]);
  ASSERT_TRUE(WriteModel(folder.path(), model).ok());
  const auto imported = Import(folder.path(), Photos(6));
  ASSERT_TRUE(imported.ok()) << imported.status().message();
  ASSERT_EQ(imported->model.images.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(imported->model.images[i].name, PhotoName(i));
    EXPECT_EQ(imported->model.images[i].id, static_cast<uint32_t>(i + 1));
  }
  EXPECT_THAT(imported->unmatched, ElementsAre("images/other.jpg"));
  EXPECT_FALSE(imported->random_points);
  EXPECT_EQ(imported->model.points3d.size(), 20u);
  // The image that was left out is gone from the tracks.
  EXPECT_EQ(imported->model.points3d[0].track.size(), 4u);
  EXPECT_TRUE(imported->warnings.empty());
  EXPECT_TRUE(CheckReconstruction(imported->model).ok());
}

TEST(ImportModel, PhotosThatTwoNamesFit) {
  const TemporaryFolder folder;
  Reconstruction model = SyntheticModel(4, 20);
  model.images[0].name = "left/" + PhotoName(0);
  model.images[1].name = "right/" + PhotoName(0);
  model.images[2].name = "left/" + PhotoName(1);
  model.images[3].name = "right/" + PhotoName(1);
  ASSERT_TRUE(WriteModel(folder.path(), model).ok());
  const auto first = Import(folder.path(), Photos(2));
  ASSERT_TRUE(first.ok()) << first.status().message();
  EXPECT_EQ(first->model.images[0].id, 1u);
  EXPECT_THAT(first->warnings,
              ElementsAre(HasSubstr("photo_000.jpg may be left/photo_000.jpg "
                                    "or right/photo_000.jpg")));
  const auto right = ImportModel(
      *FindImportSource(folder.path()), Photos(2), {100, 0, "right"});
  ASSERT_TRUE(right.ok()) << right.status().message();
  EXPECT_EQ(right->model.images[0].id, 2u);
  EXPECT_EQ(right->model.images[1].id, 4u);
  EXPECT_TRUE(right->warnings.empty());
}

TEST(ImportModel, PhotosOfAnotherSize) {
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteModel(folder.path(), SyntheticModel(3, 10)).ok());
  const auto half = Import(folder.path(), Photos(3, 320, 240));
  ASSERT_TRUE(half.ok()) << half.status().message();
  const Reconstruction& model = half->model;
  EXPECT_EQ(model.cameras[0].width, 320u);
  EXPECT_THAT(half->warnings, ElementsAre(HasSubstr("another size")));
  const auto pixel = Project(
      model.cameras[0], model.images[0].cam_from_world * model.points3d[0].xyz);
  EXPECT_NEAR((*pixel - model.images[0].points2d[0].xy).norm(), 0, 1e-9);
  const auto rotated = Import(folder.path(), Photos(3, 480, 640));
  ASSERT_FALSE(rotated.ok());
  EXPECT_THAT(rotated.status().message(), HasSubstr("shape"));
}

TEST(ImportModel, CroppedPhotosHaveAnotherShape) {
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteModel(folder.path(), SyntheticModel(3, 10)).ok());
  EXPECT_TRUE(Import(folder.path(), Photos(3, 213, 160)).ok());  // A third.
  for (const auto& [width, height] :
       {std::pair(636, 480), std::pair(640, 477), std::pair(320, 238)}) {
    const auto cropped = Import(folder.path(), Photos(3, width, height));
    ASSERT_FALSE(cropped.ok()) << width << " x " << height;
    EXPECT_THAT(cropped.status().message(), HasSubstr("cropped"));
  }
}

TEST(ImportModel, TurnsThatNoSizeShows) {
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteModel(folder.path(), SyntheticModel(3, 10)).ok());
  std::vector<SfmPhoto> photos = Photos(3);
  photos[1].orientation = 6;
  photos[2].orientation = 3;
  const auto imported = Import(folder.path(), photos);
  ASSERT_TRUE(imported.ok()) << imported.status().message();
  EXPECT_THAT(imported->turned, ElementsAre(PhotoName(2)));
}

// As COLMAP 3.8 does it, which does not heed EXIF.
TEST(ImportModel, PosesOfStoredPhotosAreTurned) {
  const TemporaryFolder folder;
  const Reconstruction model = SyntheticModel(3, 10);
  ASSERT_TRUE(WriteModel(folder.path() / "colmap", model).ok());
  WriteText(folder / "transforms.json",
            R"({"w":640,"h":480,"fl_x":500,"fl_y":500,"cx":310,"cy":250,)"
            R"("frames":[{"file_path":")" +
                PhotoName(0) +
                R"(","transform_matrix":[[1,0,0,0],[0,1,0,0],[0,0,1,0],)"
                R"([0,0,0,1]]}]})");
  std::vector<SfmPhoto> photos = Photos(3);
  photos[0].width = 240;
  photos[0].height = 320;
  for (const int orientation : {6, 8}) {
    photos[0].orientation = orientation;
    const auto colmap = Import(folder / "colmap", photos);
    ASSERT_TRUE(colmap.ok()) << colmap.status().message();
    ASSERT_EQ(colmap->warnings.size(), 2u);
    EXPECT_THAT(colmap->warnings[0], HasSubstr("as they are stored"));
    EXPECT_THAT(colmap->warnings[0], HasSubstr(PhotoName(0)));
    EXPECT_THAT(colmap->warnings[1], HasSubstr("another size"));
    const auto cameras = IndexCameras(colmap->model);
    // Every feature still lies where its point falls, in half of the size.
    for (const PosedImage& image : colmap->model.images) {
      const Camera& camera = colmap->model.cameras[cameras.at(image.camera_id)];
      for (const Point2D& feature : image.points2d) {
        if (feature.point3d_id == kNoPoint3D) continue;
        const Eigen::Vector3d& xyz =
            colmap->model.points3d[feature.point3d_id - 10].xyz;
        const auto pixel = Project(camera, image.cam_from_world * xyz);
        ASSERT_TRUE(pixel);
        EXPECT_LT((*pixel - feature.xy).norm(), 1e-6) << image.name;
      }
    }
    const auto transforms = Import(folder / "transforms.json", photos);
    ASSERT_TRUE(transforms.ok()) << transforms.status().message();
    const Camera& camera = transforms->model.cameras[0];
    EXPECT_EQ(camera.width, 240u);
    EXPECT_EQ(camera.PrincipalX(), orientation == 6 ? 115 : 125);
    EXPECT_EQ(camera.PrincipalY(), orientation == 6 ? 155 : 165);
    EXPECT_TRUE(transforms->turned.empty());
  }
  // A mirrored photo, and one that EXIF does not turn.
  for (const int orientation : {5, 1}) {
    photos[0].orientation = orientation;
    EXPECT_THAT(Import(folder / "colmap", photos).status().message(),
                HasSubstr("another shape"));
  }
}

TEST(ImportModel, NamesThatFitNothing) {
  const TemporaryFolder folder;
  Reconstruction model = SyntheticModel(3, 10);
  for (PosedImage& image : model.images) image.name = "x" + image.name;
  ASSERT_TRUE(WriteModel(folder.path(), model).ok());
  const auto imported = Import(folder.path(), Photos(3));
  ASSERT_FALSE(imported.ok());
  EXPECT_EQ(imported.status().code(), StatusCode::kBadInput);
  EXPECT_THAT(imported.status().message(), HasSubstr("xphoto_"));
}

std::string Transforms(const std::vector<std::string>& names) {
  std::string text = R"({"camera_angle_x":0.69,"frames":[)";
  for (size_t i = 0; i < names.size(); ++i) {
    // On a line along x, looking along +y.
    text += std::string(i > 0 ? "," : "") + R"({"file_path":")" + names[i] +
            R"(","transform_matrix":[[1,0,0,)" + std::to_string(i) +
            "],[0,0,-1,0],[0,1,0,0],[0,0,0,1]]}";
  }
  return text + "]}";
}

TEST(ImportModel, TransformsGetRandomPoints) {
  const TemporaryFolder folder;
  WriteText(folder / "transforms_train.json",
            Transforms({"./train/photo_000", "./train/photo_001"}));
  WriteText(folder / "transforms_test.json",
            Transforms({"./test/photo_002", "./test/none"}));
  WriteText(folder / "transforms_val.json", Transforms({"./val/photo_003"}));
  auto photos = Photos(4);
  const auto imported = Import(folder.path(), photos);
  ASSERT_TRUE(imported.ok()) << imported.status().message();
  EXPECT_TRUE(imported->random_points);
  EXPECT_EQ(imported->model.points3d.size(), 100u);
  EXPECT_EQ(imported->model.cameras.size(), 1u);
  EXPECT_EQ(imported->model.images.size(), 4u);
  EXPECT_THAT(imported->holdout, ElementsAre("photo_002.jpg", "photo_003.jpg"));
  EXPECT_THAT(imported->unmatched, ElementsAre("./test/none"));
  EXPECT_NEAR(
      CameraCentre(imported->model.images[1].cam_from_world).x(), 1, 1e-12);
}

TEST(ImportModel, PhotosThatTwoTransformsFilesHave) {
  const TemporaryFolder folder;
  WriteText(folder / "transforms_train.json",
            Transforms({"./images/photo_000", "./images/photo_001"}));
  WriteText(folder / "transforms_test.json",
            Transforms({"./images/photo_002", "images/photo_000"}));
  const auto imported = Import(folder.path(), Photos(3));
  ASSERT_TRUE(imported.ok()) << imported.status().message();
  EXPECT_EQ(imported->model.images.size(), 3u);
  EXPECT_NEAR(
      CameraCentre(imported->model.images[0].cam_from_world).x(), 0, 1e-12);
  EXPECT_THAT(imported->holdout, ElementsAre("photo_002.jpg"));
  EXPECT_TRUE(imported->unmatched.empty());
  EXPECT_THAT(imported->warnings,
              ElementsAre(testing::AllOf(HasSubstr("transforms_test.json: has"),
                                         HasSubstr("images/photo_000"))));
}

TEST(ImportModel, NerfstudioNamesHoldoutPhotosMasksAndPoints) {
  const TemporaryFolder folder;
  std::string text = Transforms(
      {"images/photo_000.jpg", "./images/photo_001.jpg", "photo_002.jpg"});
  text.replace(1,
               0,
               R"("w":1280,"h":960,"test_filenames":["images/photo_001.jpg"],)"
               R"("val_filenames":["photo_002.jpg"],"mask_path":"m.png",)"
               R"("ply_file_path":"sparse_pc.ply",)");
  WriteText(folder / "transforms.json", text);
  const auto imported = Import(folder.path(), Photos(3));
  ASSERT_TRUE(imported.ok()) << imported.status().message();
  EXPECT_THAT(imported->holdout, ElementsAre("photo_001.jpg", "photo_002.jpg"));
  EXPECT_TRUE(imported->names_masks);
  EXPECT_THAT(imported->warnings,
              ElementsAre(HasSubstr("sparse_pc.ply"),
                          testing::AllOf(HasSubstr("another size"),
                                         HasSubstr("photo_000.jpg"))));
}

// The paths of a transforms file lead from its own folder and may well go up.
// They are only compared: what is imported has the names of the photos.
TEST(ImportModel, PathsOfATransformsFileAreNotKept) {
  const TemporaryFolder folder;
  WriteText(folder / "transforms.json",
            Transforms({"../../photo_000.jpg", "/elsewhere/photo_001.jpg"}));
  const auto imported = Import(folder.path(), Photos(2));
  ASSERT_TRUE(imported.ok()) << imported.status().message();
  EXPECT_EQ(imported->model.images[0].name, PhotoName(0));
  EXPECT_EQ(imported->model.images[1].name, PhotoName(1));
}

// A focal length that makes points infinite, and sizes that make one.
TEST(ImportModel, AbsurdIntrinsicsAreTheFilesFault) {
  const TemporaryFolder folder;
  for (const char* numbers : {R"("fl_x":1e-320)",
                              R"("fl_x":1e-300,"fl_y":1e-300)",
                              R"("fl_x":1e300)",
                              R"("fl_x":600,"fl_y":1e-9)",
                              R"("fl_x":600,"w":1e300,"h":7.5e299)",
                              R"("fl_x":600,"w":1e300,"h":1e300)"}) {
    std::string text = Transforms({"photo_000.jpg", "photo_001.jpg"});
    text.replace(1, 0, std::string(numbers) + ",");
    WriteText(folder / "transforms.json", text);
    const auto imported = Import(folder.path(), Photos(2));
    ASSERT_FALSE(imported.ok()) << numbers;
    EXPECT_EQ(imported.status().code(), StatusCode::kBadInput);
    EXPECT_THAT(imported.status().message(),
                HasSubstr((folder / "transforms.json").string()));
  }
}

// The points lie farther away than the cameras, which are within the limit.
TEST(ImportModel, ComputedPointsAreCheckedToo) {
  const TemporaryFolder folder;
  std::string text = Transforms({"photo_000.jpg", "photo_001.jpg"});
  const std::string place = "[1,0,0,1]";
  text.replace(text.find(place), place.size(), "[1,0,0,9e11]");
  WriteText(folder / "transforms.json", text);
  const auto imported = Import(folder.path(), Photos(2));
  ASSERT_FALSE(imported.ok());
  EXPECT_EQ(imported.status().code(), StatusCode::kBadInput);
  EXPECT_THAT(imported.status().message(),
              HasSubstr((folder / "transforms.json").string() + ": point"));
}

TEST(ImportModel, FaultsNameTheFile) {
  const TemporaryFolder folder;
  WriteText(folder / "transforms.json", "{");
  const auto imported = Import(folder.path(), Photos(3));
  ASSERT_FALSE(imported.ok());
  EXPECT_THAT(imported.status().message(), HasSubstr("transforms.json"));
}

TEST(ImportModel, InstantNgpFox) {
  const fs::path fox = SharedData("fox");
  if (fox.empty()) GTEST_SKIP() << "FREEGS_SHARED_DATA has no fox";
  std::vector<SfmPhoto> photos;
  for (const auto& entry : fs::directory_iterator(fox / "images")) {
    SfmPhoto photo;
    photo.name = entry.path().filename().string();
    photo.width = 1080;
    photo.height = 1920;
    photos.push_back(photo);
  }
  const auto imported = Import(fox / "transforms.json", photos);
  ASSERT_TRUE(imported.ok()) << imported.status().message();
  EXPECT_EQ(imported->model.images.size(), 50u);
  ASSERT_EQ(imported->model.cameras.size(), 1u);
  EXPECT_EQ(imported->model.cameras[0].model, CameraModel::kOpenCv);
}

}  // namespace
}  // namespace freegs::sfm
