// SPDX-License-Identifier: BSD-3-Clause
// LERF-Mask and 3D-OVS: small folders of their shape.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sfm/scene/model_io.h"
#include "stages/datasets/layout.h"
#include "stages/datasets/lerf_mask.h"
#include "stages/datasets/three_d_ovs.h"
#include "stages/evaluation/evaluation.h"
#include "stages/evaluation/text_evaluation.h"
#include "stages/evaluation/true_masks.h"
#include "stages/scene/scene_alignment.h"
#include "stages/scene/scene_instances.h"
#include "tests/stages/ball_scene.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// The balls as a data set: frames 0, 4 and 8 of the training path are test
// views.
class MaskDatasetTest : public BallScene {
 protected:
  static constexpr int kTestViews[] = {0, 4, 8};

  const View& TestView(size_t k) const {
    return truth_.cameras.train[static_cast<size_t>(kTestViews[k])];
  }

  // A photograph's content is of no interest here.
  void WritePhoto(const fs::path& path) {
    ASSERT_TRUE(CreateFolders(path.parent_path()).ok());
    ASSERT_TRUE(WriteFileAtomic(path, "a photo").ok());
  }

  void WriteModel(double distortion = 0) {
    sfm::Reconstruction model;
    sfm::Camera camera;
    camera.id = 1;
    camera.width = 96;
    camera.height = 72;
    camera.model = sfm::CameraModel::kPinhole;
    camera.params = {90, 90, 48, 36};
    if (distortion != 0) {
      camera.model = sfm::CameraModel::kSimpleRadial;
      camera.params = {90, 48, 36, distortion};
    }
    model.cameras.push_back(camera);
    for (const View& view : truth_.cameras.train) {
      sfm::PosedImage image;
      image.id = static_cast<uint32_t>(model.images.size() + 1);
      image.camera_id = 1;
      image.name = view.name;
      image.cam_from_world = view.cam_from_world;
      model.images.push_back(image);
    }
    ASSERT_TRUE(sfm::WriteModel(data_ / "sparse/0", model).ok());
  }

  // The mask of a ball in a view, enlarged `zoom` times.
  void WriteMask(const fs::path& path,
                 const View& view,
                 int ball,
                 int zoom = 1) {
    ASSERT_TRUE(CreateFolders(path.parent_path()).ok());
    const Image<int32_t> labels =
        splat::RenderLabels(true_model_,
                            view.camera.Resized(96 * zoom, 72 * zoom),
                            view.cam_from_world,
                            {},
                            pool_,
                            labels_);
    ASSERT_TRUE(WriteImage(path, InstanceMask(labels, ball)).ok());
  }

  void WriteLerfMask() {
    WriteModel();
    for (const View& view : truth_.cameras.train) {
      WritePhoto(data_ / "images" / view.name);
      WritePhoto(data_ / "images_train" / view.name);
    }
    for (size_t k = 0; k < 3; ++k) {
      fs::remove(data_ / "images_train" / TestView(k).name);
    }
    // As in the release, a test view may have no masks.
    for (const size_t k : {size_t{0}, size_t{2}}) {
      const fs::path folder = data_ / "test_mask" / std::to_string(k);
      WriteMask(folder / "left ball.png", TestView(k), 0);
      WriteMask(folder / "right ball.png", TestView(k), 2);
    }
  }

  void WriteThreeDOvs() {
    for (const View& view : truth_.cameras.train) {
      WritePhoto(data_ / "images" / view.name);
    }
    for (size_t k = 0; k < 3; ++k) {
      const fs::path folder =
          data_ / "segmentations" / fs::path(TestView(k).name).stem();
      WriteMask(folder / "left_ball.png", TestView(k), 0, 2);
      WriteMask(folder / "right ball.png", TestView(k), 2, 2);
    }
    ASSERT_TRUE(WriteFileAtomic(data_ / "segmentations/classes.txt",
                                "Left Ball\r\n\nright ball \n")
                    .ok());
  }

  TextQuality Judge(const GroundTruth& truth,
                    const WorkspaceScene& scene,
                    const Sim3d& truth_from_scene,
                    const std::string& left) {
    const auto text =
        MeasureTextQuality({.scene = scene,
                            .truth = truth,
                            .truth_from_scene = truth_from_scene,
                            .cancellation = cancellation_,
                            .pool = pool_},
                           labels_,
                           {{left, {0, 0.9}}, {"right ball", {2, 0.9}}});
    EXPECT_TRUE(text.ok()) << text.status().message();
    EXPECT_TRUE(text.ok() && text->has_value());
    return text.ok() && text->has_value() ? **text : TextQuality();
  }

  fs::path data_ = temporary_.path() / "data";
};

TEST_F(MaskDatasetTest, LerfMaskIsEvaluated) {
  WriteLerfMask();
  EXPECT_EQ(DetectLayout(data_), "lerf_mask");
  const auto truth = ReadTruth(data_, "auto");
  ASSERT_TRUE(truth.ok()) << truth.status().message();
  EXPECT_EQ(truth->cameras.train.size(), 10u);
  ASSERT_EQ(truth->cameras.test.size(), 2u);
  EXPECT_EQ(truth->cameras.test[0].name, "frame_0.jpg");
  EXPECT_EQ(truth->cameras.test[1].name, "frame_8.jpg");
  ASSERT_EQ(truth->objects.size(), 2u);
  EXPECT_EQ(truth->objects[0].label, "left ball");
  EXPECT_FALSE(truth->complete);

  const WorkspaceScene scene = MakeScene();
  const auto poses = AlignWithViews(scene, truth->cameras.train, "truth");
  ASSERT_TRUE(poses.ok());
  const TextQuality text =
      Judge(*truth, scene, poses->target_from_source, "left ball");
  EXPECT_GT(*text.miou, 0.97);
  EXPECT_FALSE(text.boxes.has_value());
  // It was trained on.
  EXPECT_EQ(TrainedOn(scene, *truth).size(), 2u);

  // Pictures are measured where there are no masks, too.
  GroundTruth pictures = *truth;
  pictures.masks.clear();
  pictures.photos.clear();
  EXPECT_TRUE(TrainedOn(scene, pictures).empty());
  pictures.photos["frame_8.jpg"] = data_ / "images/frame_8.jpg";
  EXPECT_THAT(TrainedOn(scene, pictures), testing::ElementsAre("frame_8.jpg"));
}

TEST_F(MaskDatasetTest, OverlappingMasksAreAllJudged) {
  WriteLerfMask();
  const fs::path folder = data_ / "test_mask/2";
  const Image<int32_t> labels = splat::RenderLabels(true_model_,
                                                    TestView(2).camera,
                                                    TestView(2).cam_from_world,
                                                    {},
                                                    pool_,
                                                    labels_);
  ImageU8 both(96, 72, 1);
  for (size_t i = 0; i < both.size(); ++i) {
    both.data()[i] = labels.data()[i] >= 0 ? 200 : 100;
  }
  ASSERT_TRUE(WriteImage(folder / "balls.png", both).ok());
  const auto truth = ReadLerfMask(data_);
  ASSERT_TRUE(truth.ok());
  const auto layers = ReadTrueMasks(*truth, truth->cameras.test[1], pool_);
  ASSERT_TRUE(layers.ok());
  EXPECT_EQ(layers->size(), 2u);
  const auto count = [&](int object) {
    const ImageU8 mask = MaskOf(*layers, {object});
    return std::count(mask.data(), mask.data() + mask.size(), 255);
  };
  // Phrases by name: balls, left ball, right ball.
  EXPECT_GT(count(1), count(2) + count(3));
  EXPECT_GT(count(2), 100);
  truth_ = *truth;
  const auto instances = MeasureInstanceQuality(Context(MakeScene()), labels_);
  ASSERT_TRUE(instances.ok() && instances->has_value());
  EXPECT_GT(*(*instances)->objects[1].instance_iou, 0.97);
  EXPECT_LT(*(*instances)->objects[0].instance_iou, 0.7);
  EXPECT_TRUE((*instances)->panoptic.empty());
}

TEST_F(MaskDatasetTest, LerfMaskSaysWhatDoesNotFit) {
  const auto fault = [this] {
    const auto truth = ReadLerfMask(data_);
    EXPECT_EQ(truth.status().code(), StatusCode::kBadInput);
    return truth.status().message();
  };
  EXPECT_THAT(fault(), HasSubstr("test_mask"));
  ASSERT_TRUE(CreateFolders(data_ / "test_mask/0").ok());
  EXPECT_THAT(fault(), HasSubstr("no folder with masks"));
  WriteMask(data_ / "test_mask/0/a.png", TestView(0), 0);
  EXPECT_THAT(fault(), HasSubstr("neither a COLMAP model"));
  WriteModel();
  EXPECT_THAT(fault(), HasSubstr("images_train"));
  for (const View& view : truth_.cameras.train) {
    WritePhoto(data_ / "images_train" / view.name);
  }
  EXPECT_THAT(fault(), HasSubstr("there are only 0"));
  fs::remove(data_ / "images_train/frame_0.jpg");
  EXPECT_TRUE(ReadLerfMask(data_).ok());
  WriteMask(data_ / "test_mask/frame_0/a.png", TestView(0), 0);
  EXPECT_THAT(fault(), HasSubstr("second folder"));
  fs::remove_all(data_ / "test_mask/frame_0");
  WriteMask(data_ / "test_mask/frame_1/a.png", TestView(0), 0);
  EXPECT_THAT(fault(), HasSubstr("not for training"));
  fs::remove_all(data_ / "test_mask/frame_1");
  WriteMask(data_ / "test_mask/99999999999999999999999/a.png", TestView(0), 0);
  EXPECT_THAT(fault(), HasSubstr("not for training"));
}

TEST_F(MaskDatasetTest, HostileNamesAndPicturesAreRefused) {
  WriteLerfMask();
  const fs::path folder = data_ / "test_mask/0";
  ASSERT_TRUE(WriteFileAtomic(folder / "notes.txt", "no mask").ok());
  EXPECT_TRUE(ReadLerfMask(data_).ok());
  const fs::path hostile = folder / "a\nb.png";
  WriteMask(hostile, TestView(0), 0);
  EXPECT_FALSE(ReadLerfMask(data_).ok());
  fs::remove(hostile);
  WriteMask(folder / (std::string(220, 'x') + ".png"), TestView(0), 0);
  EXPECT_FALSE(ReadLerfMask(data_).ok());
  fs::remove(folder / (std::string(220, 'x') + ".png"));
  fs::copy(folder / "left ball.png", folder / "left ball.jpg");
  EXPECT_THAT(ReadLerfMask(data_).status().message(),
              HasSubstr("a second mask"));
  fs::remove(folder / "left ball.jpg");

  const auto read = [this]() -> Status {
    const auto truth = ReadLerfMask(data_);
    if (!truth.ok()) return truth.status();
    return ReadTrueMasks(*truth, truth->cameras.test[0], pool_).status();
  };
  EXPECT_TRUE(read().ok());
  ASSERT_TRUE(WriteImage(folder / "left ball.png", ImageU8(72, 96, 1)).ok());
  EXPECT_THAT(read().message(), HasSubstr("left ball.png: is of 72 x 96"));
  ASSERT_TRUE(WriteFileAtomic(folder / "left ball.png", "").ok());
  EXPECT_EQ(read().code(), StatusCode::kBadInput);
  fs::remove(folder / "left ball.png");
  fs::create_directory(folder / "left ball.png");
  EXPECT_TRUE(read().ok());  // A folder is no mask.
}

TEST_F(MaskDatasetTest, ThreeDOvsIsEvaluatedWithItsModel) {
  WriteThreeDOvs();
  WriteModel();
  const auto truth = ReadTruth(data_, "auto");
  ASSERT_TRUE(truth.ok()) << truth.status().message();
  EXPECT_EQ(truth->cameras.test.size(), 3u);
  ASSERT_EQ(truth->objects.size(), 2u);
  EXPECT_EQ(truth->objects[0].label, "Left Ball");
  EXPECT_EQ(truth->objects[1].label, "right ball");
  const TextQuality text =
      Judge(*truth, MakeScene(), truth_from_scene_, "Left Ball");
  EXPECT_GT(*text.miou, 0.9);
}

TEST_F(MaskDatasetTest, ThreeDOvsTakesTheWorkspacesCameras) {
  WriteThreeDOvs();
  auto truth = ReadThreeDOvs(data_);
  ASSERT_TRUE(truth.ok()) << truth.status().message();
  EXPECT_EQ(truth->unposed.size(), 3u);
  EXPECT_TRUE(truth->cameras.test.empty());
  WorkspaceScene scene = MakeScene();
  scene.holdout.push_back(scene.train[0]);
  scene.train.erase(scene.train.begin() + 8);
  scene.train.erase(scene.train.begin());
  const auto missing =
      TakeWorkspaceCameras(temporary_ / "workspace", scene, &*truth);
  ASSERT_TRUE(missing.ok()) << missing.status().message();
  EXPECT_THAT(*missing, testing::ElementsAre("frame_8.jpg"));
  ASSERT_EQ(truth->cameras.test.size(), 2u);
  const TextQuality text = Judge(*truth, scene, Sim3d(), "Left Ball");
  EXPECT_GT(*text.miou, 0.9);
  EXPECT_THAT(TrainedOn(scene, *truth), testing::ElementsAre("frame_4.jpg"));

  auto strange = ReadThreeDOvs(data_);
  scene.train.clear();
  scene.holdout.clear();
  EXPECT_EQ(TakeWorkspaceCameras(temporary_ / "workspace", scene, &*strange)
                .status()
                .code(),
            StatusCode::kBadInput);
}

TEST_F(MaskDatasetTest, ThreeDOvsNumbersMayHaveOtherZeros) {
  WriteMask(data_ / "segmentations/3/a.png", TestView(0), 0);
  WritePhoto(data_ / "images/003.jpg");
  const auto truth = ReadThreeDOvs(data_);
  ASSERT_TRUE(truth.ok()) << truth.status().message();
  EXPECT_EQ(truth->unposed[0], "003.jpg");
  WritePhoto(data_ / "images/03.jpg");
  EXPECT_THAT(ReadThreeDOvs(data_).status().message(), HasSubstr("several"));
  fs::remove_all(data_ / "images");
  WritePhoto(data_ / "images/4.jpg");
  EXPECT_THAT(ReadThreeDOvs(data_).status().message(),
              HasSubstr("no photograph"));
}

TEST_F(MaskDatasetTest, MasksOfADistortedPhotoAreStraightened) {
  constexpr double kDistortion = 0.4;
  WriteThreeDOvs();
  WriteModel(kDistortion);
  // A disk in the photograph.
  constexpr double kRadius = 20;
  ImageU8 disk(96, 72, 1);
  for (int y = 0; y < 72; ++y) {
    for (int x = 0; x < 96; ++x) {
      if (std::hypot(x + 0.5 - 48, y + 0.5 - 36) < kRadius) disk(x, y) = 255;
    }
  }
  const fs::path folder = data_ / "segmentations/frame_0";
  ASSERT_TRUE(WriteImage(folder / "left_ball.png", disk).ok());
  fs::remove(folder / "right ball.png");
  const auto truth = ReadThreeDOvs(data_);
  ASSERT_TRUE(truth.ok()) << truth.status().message();
  EXPECT_EQ(truth->lenses.size(), 3u);
  const auto layers = ReadTrueMasks(*truth, truth->cameras.test[0], pool_);
  ASSERT_TRUE(layers.ok()) << layers.status().message();
  const auto distorted = [](double radius) {
    const double r = radius / 90;
    return radius * (1 + kDistortion * r * r);
  };
  for (int y = 0; y < 72; ++y) {
    for (int x = 0; x < 96; ++x) {
      const double radius = std::hypot(x + 0.5 - 48, y + 0.5 - 36);
      if (std::abs(distorted(radius) - kRadius) < 1) continue;
      EXPECT_EQ((*layers)[0](x, y) != 0, distorted(radius) < kRadius);
    }
  }
}

TEST_F(MaskDatasetTest, FoldersWithoutTruthAreNamed) {
  ASSERT_TRUE(CreateFolders(data_).ok());
  EXPECT_FALSE(DetectLayout(data_).has_value());
  EXPECT_THAT(ReadTruth(data_, "auto").status().message(),
              HasSubstr("no truth in a layout known here"));
  EXPECT_EQ(ReadTruth(data_, "kitti").status().code(),
            StatusCode::kInvalidArgument);
  for (const std::string& layout : LayoutNames()) {
    EXPECT_EQ(ReadTruth(data_, layout).status().code(), StatusCode::kBadInput);
  }
}

TEST_F(MaskDatasetTest, TooManyMasksAreRefused) {
  GroundTruth truth;
  for (int i = 0; i < 257; ++i) truth.masks["v"].push_back({"x.png", 1});
  View view = TestView(0);
  view.name = "v";
  EXPECT_THAT(ReadTrueMasks(truth, view, pool_).status().message(),
              HasSubstr("257 masks"));
}

}  // namespace
}  // namespace freegs::stages
