// SPDX-License-Identifier: BSD-3-Clause
// The right lens is found for scenes drawn from each.

#include "sfm/calibration/camera_selection.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sfm/scene/model_io_binary.h"
#include "sfm/scene/pose_alignment.h"
#include "tests/sfm/noisy_scene.h"

namespace freegs::sfm {
namespace {

using testing::HasSubstr;

std::string Table(const CameraSelection& selection) {
  std::string text;
  for (const CameraCandidate& candidate : selection.candidates) {
    text += std::string(GetCameraModel(candidate.model).name) + " " +
            std::string(CameraSharingName(candidate.sharing)) + " " +
            std::to_string(candidate.parameters) + " held out " +
            std::to_string(candidate.held_out_error_px) + " bic " +
            std::to_string(candidate.bic) +
            (candidate.chosen ? " chosen " : " ") + candidate.refused + "\n";
  }
  return text;
}

NamedPoses Poses(const Reconstruction& model) {
  NamedPoses poses;
  for (const PosedImage& image : model.images) {
    poses[image.name] = image.cam_from_world;
  }
  return poses;
}

struct Lens {
  Camera camera;
  double focal_tolerance;  // Share.
  double distance = NoisyScene().distance;
};

class LensTest : public testing::TestWithParam<Lens> {};

TEST_P(LensTest, IsChosenAndRecovered) {
  NoisyScene scene;
  scene.cameras = {GetParam().camera};
  scene.distance = GetParam().distance;
  const Reconstruction truth = MakeNoisyScene(scene);
  Reconstruction model = MakeStart(scene, truth);
  const auto selection = RefineCameras({}, &model);
  ASSERT_TRUE(selection.ok()) << selection.status().message();
  const CameraCandidate& chosen = selection->candidates[selection->chosen];
  EXPECT_EQ(chosen.model, GetParam().camera.model) << Table(*selection);
  EXPECT_EQ(chosen.sharing, CameraSharing::kShared) << Table(*selection);
  ASSERT_EQ(model.cameras.size(), 1u);
  const Camera& found = model.cameras[0];
  EXPECT_EQ(found.id, 1u);
  EXPECT_NEAR(found.FocalX() / GetParam().camera.FocalX(),
              1,
              GetParam().focal_tolerance);
  EXPECT_NEAR(found.FocalY() / GetParam().camera.FocalY(),
              1,
              GetParam().focal_tolerance);
  const auto alignment = AlignPoses(Poses(model), Poses(truth));
  ASSERT_TRUE(alignment.ok());
  EXPECT_LT(alignment->max_rotation_deg, 0.2);
  EXPECT_LT(alignment->max_centre, 0.02);
  EXPECT_TRUE(CheckReconstruction(model).ok());
  EXPECT_EQ(RemoveDanglingReferences(&model), 0u);
  // The outliers are gone, and hardly anything else.
  size_t before = 0, after = 0;
  for (const Point3D& point : truth.points3d) before += point.track.size();
  for (const Point3D& point : model.points3d) after += point.track.size();
  EXPECT_LT(after, before * 0.99);
  EXPECT_GT(after, before * 0.95);
}

INSTANTIATE_TEST_SUITE_P(
    Models,
    LensTest,
    testing::Values(
        Lens{MakeCamera(CameraModel::kSimplePinhole, {500, 320, 240}), 0.003},
        Lens{MakeCamera(CameraModel::kPinhole, {500, 510, 320, 240}), 0.003},
        Lens{MakeCamera(CameraModel::kSimpleRadial, {500, 320, 240, -0.08}),
             0.003},
        Lens{MakeCamera(CameraModel::kRadial, {500, 320, 240, -0.2, 0.2}),
             0.003},
        Lens{MakeCamera(CameraModel::kOpenCv,
                        {500, 506, 320, 240, -0.2, 0.1, 0.004, -0.003}),
             0.003},
        Lens{MakeCamera(CameraModel::kOpenCvFisheye,
                        {280, 280, 320, 240, 0.05, -0.03, 0.01, -0.002}),
             0.01,
             1.5}),  // Points up to the corners: they decide how it bends.
    [](const testing::TestParamInfo<Lens>& info) {
      return std::string(GetCameraModel(info.param.camera.model).name);
    });

class SharingTest : public testing::Test {
 protected:
  CameraCandidate Choose(const CameraSelectionOptions& options = {}) {
    const Reconstruction truth = MakeNoisyScene(scene_);
    const auto selection = SelectCameras(MakeStart(scene_, truth), options);
    if (!selection.ok()) {
      ADD_FAILURE() << selection.status().message();
      return {};
    }
    table_ = Table(*selection);
    return selection->candidates[selection->chosen];
  }
  static Camera Pinhole(double focal) {
    return MakeCamera(CameraModel::kSimplePinhole, {focal, 320, 240});
  }

  NoisyScene scene_;
  std::string table_;
};

TEST_F(SharingTest, TwoFocalLengthsPerGroup) {
  scene_.cameras = {Pinhole(450), Pinhole(600)};
  const CameraCandidate chosen = Choose();
  EXPECT_EQ(chosen.sharing, CameraSharing::kPerGroup) << table_;
  EXPECT_EQ(chosen.model, CameraModel::kSimplePinhole) << table_;
  ASSERT_EQ(chosen.cameras.size(), 2u);
  EXPECT_NEAR(chosen.cameras[0].FocalX(), 450, 3);
  EXPECT_NEAR(chosen.cameras[1].FocalX(), 600, 3);
}

TEST_F(SharingTest, TheSameLensInTwoGroupsIsShared) {
  scene_.cameras = {Pinhole(500), Pinhole(500), Pinhole(500)};
  const CameraCandidate chosen = Choose();
  EXPECT_EQ(chosen.sharing, CameraSharing::kShared) << table_;
  EXPECT_EQ(chosen.parameters, 1) << table_;
  EXPECT_NEAR(chosen.cameras[0].FocalX(), 500, 3);
}

TEST_F(SharingTest, TwoSizesAreNeverShared) {
  scene_.cameras = {Pinhole(500), Pinhole(500)};
  scene_.cameras[1].width = 700;
  const CameraCandidate chosen = Choose();
  EXPECT_EQ(chosen.cameras.size(), 2u) << table_;
}

TEST_F(SharingTest, ZoomBetweenPhotosIsPerPhoto) {
  for (int i = 0; i < scene_.num_images; ++i) {
    scene_.cameras.push_back(Pinhole(460 + 37 * (i * 5 % 12) / 4.0));
  }
  Reconstruction model = MakeNoisyScene(scene_);
  // The mapper believed in one camera.
  model.cameras.resize(1);
  for (PosedImage& image : model.images) image.camera_id = 1;
  model.cameras[0].params[0] = 510;
  const auto selection = SelectCameras(model, {});
  ASSERT_TRUE(selection.ok()) << selection.status().message();
  const CameraCandidate& chosen = selection->candidates[selection->chosen];
  EXPECT_EQ(chosen.sharing, CameraSharing::kPerPhoto) << Table(*selection);
  EXPECT_EQ(chosen.model, CameraModel::kSimplePinhole) << Table(*selection);
  ASSERT_EQ(chosen.cameras.size(), scene_.cameras.size());
  for (size_t i = 0; i < chosen.cameras.size(); ++i) {
    EXPECT_NEAR(chosen.cameras[i].FocalX(), scene_.cameras[i].FocalX(), 8);
  }
}

TEST_F(SharingTest, OnlyWhatIsAskedIsTried) {
  scene_.cameras = {Pinhole(450), Pinhole(600)};
  CameraSelectionOptions options;
  options.shared = options.per_group = false;
  EXPECT_EQ(Choose(options).sharing, CameraSharing::kPerPhoto);
  EXPECT_THAT(table_, HasSubstr("OPENCV per_photo"));
  options = {};
  options.models = {CameraModel::kRadial};
  options.per_photo = false;
  EXPECT_EQ(Choose(options).model, CameraModel::kRadial);
}

// Else a second choice of cameras could not tell the groups apart.
TEST(RestoreCameraGroups, GroupsAreThoseBeforeTheFirstChoice) {
  Reconstruction model;
  model.cameras = {
      MakeCamera(CameraModel::kRadial, {500, 320, 240, 0.1, 0}),
      MakeCamera(CameraModel::kRadial, {700, 320, 240, 0, 0}),
  };
  model.cameras[1].id = 5;
  for (uint32_t id = 1; id <= 4; ++id) {
    PosedImage& image = model.images.emplace_back();
    image.id = id;
    image.camera_id = id <= 2 ? 1 : 5;
    image.name = std::to_string(id);
  }
  CameraGroups groups;
  NoteCameraGroups(model, &groups);
  for (const CameraSharing sharing :
       {CameraSharing::kShared, CameraSharing::kPerPhoto}) {
    AssignCameras(CameraModel::kSimpleRadial, sharing, &model);
    EXPECT_EQ(NumCameras(model, CameraSharing::kPerGroup),
              sharing == CameraSharing::kShared ? 1u : 4u);
    RestoreCameraGroups(groups, &model);
    EXPECT_EQ(NumCameras(model, CameraSharing::kPerGroup), 2u);
    EXPECT_EQ(model.images[0].camera_id, model.images[1].camera_id);
    EXPECT_EQ(model.images[2].camera_id, model.images[3].camera_id);
    EXPECT_TRUE(CheckReconstruction(model).ok());
  }
}

// Whether the second choice succeeds or not, the model is as exact as before.
TEST(RefineCamerasAgain, AChoiceThatFailsLeavesTheFirstOne) {
  NoisyScene scene;
  scene.num_points = 200;
  for (int i = 0; i < scene.num_images; ++i) {
    scene.cameras.push_back(MakeCamera(CameraModel::kSimplePinhole,
                                       {450.0 + 20 * (i * 5 % 12), 320, 240}));
  }
  Reconstruction model = MakeNoisyScene(scene);
  CameraGroups groups;  // COLMAP believed in one camera.
  for (const PosedImage& image : model.images) groups[image.name] = 1;
  const auto bytes = [](const Reconstruction& any) {
    return CamerasToBinary(any.cameras) + ImagesToBinary(any.images) +
           PointsToBinary(any.points3d);
  };
  CameraSelectionOptions options;
  options.models = {CameraModel::kSimplePinhole};
  Reconstruction poor = model;
  for (Point3D& point : poor.points3d) {
    point.track.resize(std::min<size_t>(point.track.size(), 2));
  }
  const std::string before = bytes(poor);
  const auto failed = RefineCamerasAgain(options, groups, &poor);
  EXPECT_EQ(failed.status().code(), StatusCode::kUnusableResult);
  EXPECT_TRUE(bytes(poor) == before);

  options.shared = options.per_photo = false;  // The groups alone.
  const auto selection = RefineCamerasAgain(options, groups, &model);
  ASSERT_TRUE(selection.ok()) << selection.status().message();
  EXPECT_EQ(model.cameras.size(), 1u);
}

TEST(SelectCameras, SameForAnyNumberOfThreads) {
  NoisyScene scene;
  scene.num_points = 200;
  scene.cameras = {
      MakeCamera(CameraModel::kSimpleRadial, {500, 320, 240, -0.08})};
  const Reconstruction start = MakeStart(scene, MakeNoisyScene(scene));
  std::string first;
  for (const int threads : {1, 2, 5}) {
    CameraSelectionOptions options;
    options.num_threads = threads;
    Reconstruction model = start;
    const auto selection = RefineCameras(options, &model);
    ASSERT_TRUE(selection.ok()) << selection.status().message();
    std::string bytes = CamerasToBinary(model.cameras) +
                        ImagesToBinary(model.images) +
                        PointsToBinary(model.points3d);
    for (const CameraCandidate& candidate : selection->candidates) {
      bytes += CamerasToBinary(candidate.cameras);
    }
    if (first.empty()) first = bytes;
    EXPECT_TRUE(bytes == first) << threads;
  }
}

TEST(SelectCameras, FewObservationsAreDrawnAndEveryImageKeepsSome) {
  NoisyScene scene;
  scene.num_points = 1500;
  scene.cameras = {MakeCamera(CameraModel::kSimplePinhole, {500, 320, 240})};
  CameraSelectionOptions options;
  options.max_observations = 2000;
  const auto selection =
      SelectCameras(MakeStart(scene, MakeNoisyScene(scene)), options);
  ASSERT_TRUE(selection.ok()) << selection.status().message();
  EXPECT_GE(selection->observations, 2000u);
  EXPECT_LT(selection->observations, 2100u);
  const double share =
      static_cast<double>(selection->held_out) /
      static_cast<double>(selection->held_out + selection->observations);
  EXPECT_NEAR(share, 0.15, 0.03);
  EXPECT_EQ(selection->candidates[selection->chosen].parameters, 1)
      << Table(*selection);
}

TEST(SelectCameras, APartOfManyPhotosFindsTheSameLens) {
  NoisyScene scene;
  scene.num_images = 60;
  scene.cameras = {
      MakeCamera(CameraModel::kRadial, {500, 320, 240, -0.2, 0.2}),
      MakeCamera(CameraModel::kRadial, {400, 320, 240, -0.2, 0.2})};
  CameraSelectionOptions options;
  options.per_photo = false;
  const Reconstruction start = MakeStart(scene, MakeNoisyScene(scene));
  for (const size_t images : {20, 60}) {
    options.max_images = images;
    const auto selection = SelectCameras(start, options);
    ASSERT_TRUE(selection.ok()) << selection.status().message();
    EXPECT_EQ(selection->images, images);
    const CameraCandidate& chosen = selection->candidates[selection->chosen];
    EXPECT_EQ(chosen.model, CameraModel::kRadial) << Table(*selection);
    EXPECT_EQ(chosen.sharing, CameraSharing::kPerGroup) << Table(*selection);
  }
  options.max_images = 2;
  EXPECT_FALSE(SelectCameras(start, options).ok());
}

TEST(SelectCameras, TooLittleToChooseBy) {
  NoisyScene scene;
  scene.cameras = {MakeCamera(CameraModel::kSimplePinhole, {500, 320, 240})};
  const Reconstruction good = MakeStart(scene, MakeNoisyScene(scene));
  Reconstruction model = good;
  const auto message = [&] {
    const Reconstruction before = model;
    const auto result = RefineCameras({}, &model);
    EXPECT_FALSE(result.ok());
    EXPECT_EQ(model.images.size(), before.images.size());
    return result.status().message();
  };
  model = {};
  EXPECT_THAT(message(), HasSubstr("three photos"));
  model = good;
  model.images.resize(2);
  EXPECT_THAT(message(), HasSubstr("three photos"));
  model = good;
  model.points3d.clear();
  EXPECT_THAT(message(), HasSubstr("only 0 observations"));
  model = good;
  for (PosedImage& image : model.images) {  // All turned away.
    image.cam_from_world.rotation =
        Eigen::AngleAxisd(3.14159, Eigen::Vector3d::UnitY()) *
        image.cam_from_world.rotation;
    image.cam_from_world.translation.z() *= -1;
  }
  EXPECT_THAT(message(), HasSubstr("in front of their cameras"));
  model = good;
  model.points3d[3].xyz.y() = std::nan("");
  EXPECT_THAT(message(), HasSubstr("not a number"));
  model = good;
  for (PosedImage& image : model.images) image.cam_from_world = {};
  for (PosedImage& image : model.images)
    image.cam_from_world.translation.z() = 9;
  EXPECT_THAT(message(), HasSubstr("different places"));
  CameraSelectionOptions options;
  options.models = {CameraModel::kFov};
  EXPECT_EQ(SelectCameras(good, options).status().code(),
            StatusCode::kInvalidArgument);
  options = {};
  CancellationToken stop;
  stop.Cancel();
  options.cancellation = &stop;
  EXPECT_EQ(SelectCameras(good, options).status().code(),
            StatusCode::kInterrupted);
}

}  // namespace
}  // namespace freegs::sfm
