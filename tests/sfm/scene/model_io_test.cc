// SPDX-License-Identifier: BSD-3-Clause
// Model files: round trips, and files that are truncated, corrupt or hostile.

#include "sfm/scene/model_io.h"

#include <cstdint>
#include <cstring>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/files.h"
#include "core/random.h"
#include "sfm/scene/model_io_binary.h"
#include "sfm/scene/model_io_text.h"
#include "tests/sfm/synthetic_model.h"
#include "tests/temporary_folder.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string AllBytes(const Reconstruction& model) {
  return CamerasToBinary(model.cameras) + ImagesToBinary(model.images) +
         PointsToBinary(model.points3d);
}

Reconstruction SmallModel() {
  Reconstruction model = SyntheticModel(3, 4);
  model.images[1].name = "a folder/name with  spaces.jpg";
  model.images[2].points2d.clear();
  for (Point3D& point : model.points3d) point.track.pop_back();
  Camera second = SyntheticModel(1, 0, CameraModel::kPinhole).cameras[0];
  second.id = 9;
  model.cameras.push_back(second);
  model.images[2].camera_id = 9;
  return model;
}

// Puts a text into little-endian bytes as COLMAP's binary format has them.
template <typename T>
std::string Bytes(T value) {
  return std::string(reinterpret_cast<const char*>(&value), sizeof(value));
}

TEST(ModelIo, BinaryLayoutIsColmaps) {
  Camera camera;
  camera.id = 3;
  camera.model = CameraModel::kSimplePinhole;
  camera.width = 8;
  camera.height = 6;
  camera.params = {10, 4, 3};
  EXPECT_EQ(CamerasToBinary({camera}),
            Bytes<uint64_t>(1) + Bytes<uint32_t>(3) + Bytes<int32_t>(0) +
                Bytes<uint64_t>(8) + Bytes<uint64_t>(6) + Bytes(10.0) +
                Bytes(4.0) + Bytes(3.0));
  PosedImage image;
  image.id = 5;
  image.camera_id = 3;
  image.name = "a.png";
  image.cam_from_world.rotation = Eigen::Quaterniond(0, 1, 0, 0);
  image.cam_from_world.translation = {7, 8, 9};
  image.points2d = {{{0.5, 1.5}, 11}, {{2.5, 3.5}, kNoPoint3D}};
  EXPECT_EQ(ImagesToBinary({image}),
            Bytes<uint64_t>(1) + Bytes<uint32_t>(5) + Bytes(0.0) + Bytes(1.0) +
                Bytes(0.0) + Bytes(0.0) + Bytes(7.0) + Bytes(8.0) + Bytes(9.0) +
                Bytes<uint32_t>(3) + std::string("a.png\0", 6) +
                Bytes<uint64_t>(2) + Bytes(0.5) + Bytes(1.5) +
                Bytes<uint64_t>(11) + Bytes(2.5) + Bytes(3.5) +
                Bytes<int64_t>(-1));
  Point3D point;
  point.id = 11;
  point.xyz = {1, 2, 3};
  point.rgb = {4, 5, 6};
  point.error = 0.25;
  point.track = {{5, 0}};
  EXPECT_EQ(PointsToBinary({point}),
            Bytes<uint64_t>(1) + Bytes<uint64_t>(11) + Bytes(1.0) + Bytes(2.0) +
                Bytes(3.0) + "\4\5\6" + Bytes(0.25) + Bytes<uint64_t>(1) +
                Bytes<uint32_t>(5) + Bytes<uint32_t>(0));
}

TEST(ModelIo, FisheyesOfNewerReleases) {
  const auto header = [](int32_t model) {
    return Bytes<uint64_t>(1) + Bytes<uint32_t>(1) + Bytes(model) +
           Bytes<uint64_t>(8) + Bytes<uint64_t>(6);
  };
  std::vector<Camera> cameras;
  ASSERT_TRUE(ParseCamerasBinary(
                  header(14) + Bytes(5.0) + Bytes(4.0) + Bytes(3.0), &cameras)
                  .ok());
  ASSERT_TRUE(ParseCamerasBinary(header(15) + Bytes(5.0) + Bytes(6.0) +
                                     Bytes(4.0) + Bytes(3.0),
                                 &cameras)
                  .ok());
  ASSERT_TRUE(ParseCamerasText("1 SIMPLE_FISHEYE 8 6 5 4 3\n"
                               "2 FISHEYE 8 6 5 6 4 3\n",
                               &cameras)
                  .ok());
  ASSERT_EQ(cameras.size(), 4u);
  for (size_t i = 0; i < cameras.size(); ++i) {
    EXPECT_EQ(cameras[i].model, CameraModel::kOpenCvFisheye);
    EXPECT_THAT(cameras[i].params,
                testing::ElementsAre(5, i % 2 == 0 ? 5 : 6, 4, 3, 0, 0, 0, 0));
  }
  EXPECT_FALSE(ParseCamerasText("2 FISHEYE 8 6 5 4 3", &cameras).ok());

  // The others are named.
  const std::pair<int32_t, const char*> others[] = {
      {11, "RAD_TAN_THIN_PRISM_FISHEYE"},
      {12, "SIMPLE_DIVISION"},
      {13, "DIVISION"},
      {16, "EUCM"},
      {17, "EQUIRECTANGULAR"}};
  for (const auto& [number, name] : others) {
    const auto says = testing::AllOf(
        HasSubstr("camera model " + std::string(name) + " of newer releases"),
        HasSubstr("SIMPLE_FISHEYE and FISHEYE"));
    EXPECT_THAT(ParseCamerasBinary(header(number), &cameras).message(), says);
    EXPECT_THAT(ParseCamerasText("1 " + std::string(name) + " 8 6 1", &cameras)
                    .message(),
                says);
  }
  for (const int32_t number : {-1, 18, INT32_MIN, INT32_MAX}) {
    EXPECT_THAT(ParseCamerasBinary(header(number), &cameras).message(),
                HasSubstr(std::to_string(number) + " is unknown"));
  }
}

TEST(ModelIo, RoundTripsBothFormatsExactly) {
  const TemporaryFolder folder;
  const Reconstruction model = SmallModel();
  for (const ModelFormat format : {ModelFormat::kBinary, ModelFormat::kText}) {
    const fs::path path =
        folder.path() / (format == ModelFormat::kText ? "text" : "binary");
    ASSERT_TRUE(WriteModel(path, model, format).ok());
    EXPECT_EQ(DetectModelFormat(path), format);
    const auto read = ReadModel(path);
    ASSERT_TRUE(read.ok()) << read.status().message();
    EXPECT_EQ(AllBytes(*read), AllBytes(model));
    EXPECT_EQ(read->images[1].name, "a folder/name with  spaces.jpg");
  }
}

TEST(ModelIo, MissingFilesAreNamed) {
  const TemporaryFolder folder;
  EXPECT_FALSE(DetectModelFormat(folder.path()));
  const auto read = ReadModel(folder.path());
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.status().code(), StatusCode::kBadInput);
  EXPECT_THAT(read.status().message(), HasSubstr(folder.path().string()));
}

TEST(ModelIo, ExtraFilesOfNewerReleasesAreIgnored) {
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteModel(folder.path(), SmallModel()).ok());
  ASSERT_TRUE(WriteFileAtomic(folder.path() / "rigs.bin", "whatever").ok());
  ASSERT_TRUE(WriteFileAtomic(folder.path() / "frames.bin", "").ok());
  EXPECT_TRUE(ReadModel(folder.path()).ok());
}

TEST(ModelIo, TextAsPeopleWriteIt) {
  std::vector<PosedImage> images;
  ASSERT_TRUE(ParseImagesText("# comment\n\n"
                              "1 1 0 0 0 0 0 0 1 one.jpg\r\n"
                              "\r\n"
                              "  2 2 0 0 0 1e-3 -4 5 1  my photo.jpg  \n"
                              "10.5 11.5 -1 12.5 13.5 77\n"
                              "3 1 0 0 0 0 0 0 1 last.jpg",
                              &images)
                  .ok());
  ASSERT_EQ(images.size(), 3u);
  EXPECT_EQ(images[1].name, "my photo.jpg");
  EXPECT_DOUBLE_EQ(images[1].cam_from_world.rotation.w(), 1);
  ASSERT_EQ(images[1].points2d.size(), 2u);
  EXPECT_EQ(images[1].points2d[0].point3d_id, kNoPoint3D);
  EXPECT_EQ(images[1].points2d[1].point3d_id, 77u);
  EXPECT_TRUE(images[2].points2d.empty());
}

TEST(ModelIo, TextFaultsNameTheLine) {
  std::vector<Camera> cameras;
  Status status = ParseCamerasText("# a\n1 PANORAMA 3 4 5", &cameras);
  EXPECT_THAT(status.message(), HasSubstr("line 2"));
  EXPECT_THAT(status.message(), HasSubstr("PANORAMA"));
  EXPECT_FALSE(ParseCamerasText("1 PINHOLE 3 4 5", &cameras).ok());
  EXPECT_FALSE(ParseCamerasText("1 PINHOLE 3 4 5 6 7 8 9", &cameras).ok());
  EXPECT_FALSE(ParseCamerasText("-1 PINHOLE 3 4 5 6 7 8", &cameras).ok());
  std::vector<PosedImage> images;
  EXPECT_FALSE(ParseImagesText("1 1 0 0 0 0 0 0 1\n", &images).ok());
  EXPECT_FALSE(ParseImagesText("1 1 0 0 0 0 0 0 1 a\n1 2", &images).ok());
  std::vector<Point3D> points;
  EXPECT_FALSE(ParsePointsText("1 0 0 0 256 0 0 1", &points).ok());
  EXPECT_FALSE(ParsePointsText("1 0 0 0 0 0 0 1 5", &points).ok());
}

TEST(ModelIo, InconsistentModelsAreRefused) {
  const TemporaryFolder folder;
  const auto refuses = [&](const Reconstruction& model, const char* text) {
    ASSERT_TRUE(WriteModel(folder.path(), model).ok());
    const auto read = ReadModel(folder.path());
    ASSERT_FALSE(read.ok());
    EXPECT_THAT(read.status().message(), HasSubstr(text));
  };
  Reconstruction model = SmallModel();
  model.images[0].camera_id = 77;
  refuses(model, "camera 77");
  model = SmallModel();
  model.images[1].id = model.images[0].id;
  refuses(model, "same id");
  model = SmallModel();
  model.images[1].name = model.images[0].name;
  refuses(model, "twice");
  model = SmallModel();
  model.points3d[0].xyz.x() = std::nan("");
  refuses(model, "not a number");
  model = SmallModel();
  model.images[0].cam_from_world.rotation.coeffs().setZero();
  refuses(model, "pose");
  model = SmallModel();
  model.cameras[0].params[0] = -1;
  refuses(model, "focal length");
  // A whole model in an absurd unit, of which squares would be infinite.
  for (const double scale : {1e14, 1e200, 1e300}) {
    model = SmallModel();
    model.images[0].cam_from_world.translation *= scale;
    refuses(model, "image 'photo_000.jpg' is farther than");
    model = SmallModel();
    model.points3d[0].xyz *= scale;
    refuses(model, "point 10 is farther than");
  }
}

TEST(ModelIo, NamesThatLeaveTheFolderAreRefused) {
  const TemporaryFolder folder;
  for (const ModelFormat format : {ModelFormat::kBinary, ModelFormat::kText}) {
    const fs::path path =
        folder.path() / (format == ModelFormat::kText ? "text" : "binary");
    for (const char* name :
         {"../a.jpg", "/a.jpg", "a/../../b.jpg", "..", "a/"}) {
      Reconstruction model = SmallModel();
      model.images[1].name = name;
      ASSERT_TRUE(WriteModel(path, model, format).ok());
      const auto read = ReadModel(path);
      ASSERT_FALSE(read.ok()) << name;
      EXPECT_EQ(read.status().code(), StatusCode::kBadInput);
      EXPECT_THAT(read.status().message(), HasSubstr(path.string()));
      EXPECT_THAT(read.status().message(), HasSubstr(name));
    }
  }
}

// A count far beyond the file must be refused before memory is taken for it.
TEST(ModelIo, LyingCountsTakeNoMemory) {
  for (const uint64_t count :
       {uint64_t{1} << 62, uint64_t{1} << 40, ~uint64_t{0}}) {
    const std::string bytes = Bytes(count) + std::string(200, '\1');
    std::vector<Camera> cameras;
    EXPECT_FALSE(ParseCamerasBinary(bytes, &cameras).ok());
    std::vector<PosedImage> images;
    EXPECT_FALSE(ParseImagesBinary(bytes, &images).ok());
    std::vector<Point3D> points;
    EXPECT_FALSE(ParsePointsBinary(bytes, &points).ok());
    // Also for the lists inside of items.
    std::string image = ImagesToBinary(SyntheticModel(1, 1).images);
    std::memcpy(image.data() + image.size() - 2 * 24 - 8, &count, 8);
    EXPECT_FALSE(ParseImagesBinary(image, &images).ok());
  }
}

struct Files {
  std::string cameras, images, points;
};

// Parses and, if that worked, checks: must return, whatever the bytes.
bool Survives(const Files& files, ModelFormat format) {
  Reconstruction model;
  const bool binary = format == ModelFormat::kBinary;
  const bool parsed =
      (binary ? ParseCamerasBinary(files.cameras, &model.cameras)
              : ParseCamerasText(files.cameras, &model.cameras))
          .ok() &&
      (binary ? ParseImagesBinary(files.images, &model.images)
              : ParseImagesText(files.images, &model.images))
          .ok() &&
      (binary ? ParsePointsBinary(files.points, &model.points3d)
              : ParsePointsText(files.points, &model.points3d))
          .ok();
  if (!parsed || !CheckReconstruction(model).ok()) return false;
  RemoveDanglingReferences(&model);
  return RemoveDanglingReferences(&model) == 0;
}

class ModelFuzzTest : public testing::TestWithParam<ModelFormat> {
 protected:
  Files Valid() const {
    const Reconstruction model = SmallModel();
    if (GetParam() == ModelFormat::kBinary) {
      return {CamerasToBinary(model.cameras),
              ImagesToBinary(model.images),
              PointsToBinary(model.points3d)};
    }
    return {CamerasToText(model.cameras),
            ImagesToText(model.images),
            PointsToText(model.points3d)};
  }
};

TEST_P(ModelFuzzTest, EveryPrefix) {
  const Files valid = Valid();
  ASSERT_TRUE(Survives(valid, GetParam()));
  for (std::string Files::*member :
       {&Files::cameras, &Files::images, &Files::points}) {
    for (size_t size = 0; size < (valid.*member).size(); ++size) {
      Files cut = valid;
      (cut.*member).resize(size);
      const bool survived = Survives(cut, GetParam());
      if (GetParam() == ModelFormat::kBinary) {
        EXPECT_FALSE(survived) << size;
      }
    }
  }
}

TEST_P(ModelFuzzTest, RandomBytes) {
  const Files valid = Valid();
  RandomStream random(11, static_cast<uint64_t>(GetParam()));
  for (int round = 0; round < 20000; ++round) {
    Files changed = valid;
    std::string& file = round % 3 == 0   ? changed.cameras
                        : round % 3 == 1 ? changed.images
                                         : changed.points;
    const int flips = 1 + static_cast<int>(random.Index(4));
    for (int i = 0; i < flips; ++i) {
      file[random.Index(file.size())] =
          random.Index(2) == 0 ? static_cast<char>(random.Index(256))
                               : "\0\xff\x7f\x80 -9en\n"[random.Index(11)];
    }
    Survives(changed, GetParam());
  }
}

INSTANTIATE_TEST_SUITE_P(Formats,
                         ModelFuzzTest,
                         testing::Values(ModelFormat::kBinary,
                                         ModelFormat::kText));

}  // namespace
}  // namespace freegs::sfm
