// SPDX-License-Identifier: BSD-3-Clause
// Derivatives, recovery of known scenes, the gauge, and degenerate input.

#include "sfm/calibration/bundle_adjustment.h"

#include <ceres/jet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sfm/scene/camera_projection.h"
#include "sfm/scene/model_io_binary.h"
#include "sfm/scene/pose_alignment.h"
#include "sfm/scene/reconstruction_measures.h"
#include "tests/sfm/noisy_scene.h"

namespace freegs::sfm {
namespace {

using testing::HasSubstr;

class ProjectionTest : public testing::TestWithParam<CameraModelInfo> {};

// Ceres differentiates Distort<Jet>; everything else uses Project.
TEST_P(ProjectionTest, DerivativesAreThoseOfProject) {
  constexpr int kMax = 16;
  using Jet = ceres::Jet<double, kMax>;
  RandomStream random(5, 2);
  Camera camera = SyntheticModel(1, 0, GetParam().model).cameras[0];
  const int num_focal = GetParam().num_focal;
  const int num_distortion = static_cast<int>(camera.Distortion().size());
  for (int repeat = 0; repeat < 50; ++repeat) {
    for (int i = num_focal + 2; i < GetParam().num_params; ++i) {
      camera.params[i] = 0.2 * random.Uniform() + 0.01;
    }
    Eigen::Vector2d point(random.Normal(), random.Normal());
    if (repeat == 0) point.setZero();  // On the axis.
    std::vector<Jet> distortion;
    for (int i = 0; i < num_distortion; ++i) {
      distortion.emplace_back(camera.Distortion()[i], 2 + i);
    }
    const Vector2<Jet> uv =
        Distort<Jet>(camera.model,
                     distortion.data(),
                     Vector2<Jet>(Jet(point.x(), 0), Jet(point.y(), 1)));
    const auto project = [&] {
      return *Project(camera, Eigen::Vector3d(point.x(), point.y(), 1));
    };
    const Eigen::Vector2d pixel(
        camera.FocalX() * uv.x().a + camera.PrincipalX(),
        camera.FocalY() * uv.y().a + camera.PrincipalY());
    EXPECT_NEAR((pixel - project()).norm(), 0, 1e-9);
    for (int k = 0; k < 2 + num_distortion; ++k) {
      double& variable = k < 2 ? point[k] : camera.params[num_focal + k];
      const double value = variable;
      constexpr double kStep = 1e-5;
      variable = value + kStep;
      const Eigen::Vector2d above = project();
      variable = value - kStep;
      const Eigen::Vector2d below = project();
      variable = value;
      const Eigen::Vector2d expected = (above - below) / (2 * kStep);
      const Eigen::Vector2d found(camera.FocalX() * uv.x().v[k],
                                  camera.FocalY() * uv.y().v[k]);
      EXPECT_NEAR((found - expected).norm(), 0, 1e-5 * (10 + expected.norm()))
          << "variable " << k;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Models,
                         ProjectionTest,
                         testing::ValuesIn(CameraModels().begin(),
                                           CameraModels().end()),
                         [](const testing::TestParamInfo<CameraModelInfo>& p) {
                           return std::string(p.param.name);
                         });

// Pixels, over the points that are adjusted: those that two photos see.
double MeanError(Reconstruction model) {
  std::erase_if(model.points3d,
                [](const Point3D& point) { return point.track.size() < 2; });
  return MeasureReconstruction(model).mean_reprojection_error_px;
}

class AdjustBundleTest : public testing::TestWithParam<Camera> {};

TEST_P(AdjustBundleTest, FindsTheExactSceneAgain) {
  NoisyScene scene;
  scene.num_images = 8;
  scene.num_points = 150;
  scene.noise_px = scene.outliers = 0;
  scene.cameras = {GetParam()};
  const Reconstruction truth = MakeNoisyScene(scene);
  Reconstruction model = MakeStart(scene, truth);
  model.cameras = {ConvertCamera(model.cameras[0], GetParam().model)};
  const Rigid3d first = model.images[0].cam_from_world;
  BundleAdjustmentOptions options;
  options.max_iterations = 200;
  options.function_tolerance = 1e-14;
  const double error = MeanError(model);
  const Status adjusted = AdjustBundle(options, &model);
  ASSERT_TRUE(adjusted.ok()) << adjusted.message();
  EXPECT_GT(error, 0.1);
  EXPECT_LT(MeanError(model), 1e-4);
  const double scale = GetParam().FocalX();
  for (size_t i = 0; i < GetParam().params.size(); ++i) {
    const bool pixels =
        i < GetParam().params.size() - GetParam().Distortion().size();
    EXPECT_NEAR(model.cameras[0].params[i],
                GetParam().params[i],
                pixels ? 1e-4 * scale : 2e-3)
        << i;
  }
  NamedPoses found, wanted;
  for (const PosedImage& image : model.images) {
    found[image.name] = image.cam_from_world;
  }
  for (const PosedImage& image : truth.images) {
    wanted[image.name] = image.cam_from_world;
  }
  const auto alignment = AlignPoses(found, wanted);
  ASSERT_TRUE(alignment.ok());
  EXPECT_LT(alignment->max_centre, 1e-4);
  EXPECT_LT(alignment->max_rotation_deg, 1e-2);
  // The frame is held by the first image.
  EXPECT_EQ(model.images[0].cam_from_world.translation, first.translation);
  EXPECT_EQ(model.images[0].cam_from_world.rotation.coeffs(),
            first.rotation.coeffs());
}

INSTANTIATE_TEST_SUITE_P(
    Models,
    AdjustBundleTest,
    testing::Values(
        MakeCamera(CameraModel::kSimplePinhole, {500, 320, 240}),
        MakeCamera(CameraModel::kPinhole, {500, 510, 320, 240}),
        MakeCamera(CameraModel::kSimpleRadial, {500, 320, 240, -0.08}),
        MakeCamera(CameraModel::kRadial, {500, 320, 240, -0.2, 0.1}),
        MakeCamera(CameraModel::kOpenCv,
                   {500, 506, 320, 240, -0.2, 0.1, 0.004, -0.003}),
        MakeCamera(CameraModel::kOpenCvFisheye,
                   {280, 282, 320, 240, 0.05, -0.03, 0.01, -0.002})));

class AdjustmentTest : public testing::Test {
 protected:
  AdjustmentTest() {
    scene_.num_images = 6;
    scene_.num_points = 100;
    scene_.cameras = {MakeCamera(CameraModel::kSimplePinhole, {500, 320, 240})};
    truth_ = MakeNoisyScene(scene_);
    model_ = MakeStart(scene_, truth_);
  }

  std::string Bytes() const {
    return CamerasToBinary(model_.cameras) + ImagesToBinary(model_.images) +
           PointsToBinary(model_.points3d);
  }
  // Fails, and leaves the model as it was.
  std::string Error(const BundleAdjustmentOptions& options = {}) {
    const std::string before = Bytes();
    const Status adjusted = AdjustBundle(options, &model_);
    EXPECT_FALSE(adjusted.ok());
    EXPECT_TRUE(Bytes() == before);
    return adjusted.message();
  }

  NoisyScene scene_;
  Reconstruction truth_;
  Reconstruction model_;
};

TEST_F(AdjustmentTest, SameBytesEveryTime) {
  const Reconstruction start = model_;
  ASSERT_TRUE(AdjustBundle({}, &model_).ok());
  const std::string first = Bytes();
  model_ = start;
  ASSERT_TRUE(AdjustBundle({}, &model_).ok());
  EXPECT_TRUE(Bytes() == first);
}

TEST_F(AdjustmentTest, TwoImagesWork) {
  model_.images.resize(2);
  const double error = MeanError(model_);
  const Status adjusted = AdjustBundle({}, &model_);
  ASSERT_TRUE(adjusted.ok()) << adjusted.message();
  EXPECT_LT(MeanError(model_), error);
}

// Other solvers for the poses.
TEST_F(AdjustmentTest, HundredsAndThousandsOfImages) {
  for (const int images : {120, 210, 1010}) {
    scene_.num_images = images;
    scene_.num_points = 40;
    model_ = MakeStart(scene_, MakeNoisyScene(scene_));
    const double error = MeanError(model_);
    const Status adjusted = AdjustBundle({}, &model_);
    ASSERT_TRUE(adjusted.ok()) << adjusted.message();
    EXPECT_LT(MeanError(model_), 0.8 * error) << images;
    EXPECT_NEAR(model_.cameras[0].FocalX(), 500, 2) << images;
  }
}

TEST_F(AdjustmentTest, ObservationsBehindTheCameraAreLeftOut) {
  Point3D& point = model_.points3d[0];
  point.xyz = CameraCentre(model_.images[0].cam_from_world) * 1.5;
  const Status adjusted = AdjustBundle({}, &model_);
  ASSERT_TRUE(adjusted.ok()) << adjusted.message();
  EXPECT_NEAR(model_.cameras[0].FocalX(), 500, 5);
}

TEST_F(AdjustmentTest, DegenerateInput) {
  const Reconstruction good = model_;
  model_.points3d.clear();
  EXPECT_THAT(Error(), HasSubstr("there are none"));
  model_ = {};
  EXPECT_THAT(Error(), HasSubstr("there are none"));
  model_ = good;
  model_.images.resize(1);
  EXPECT_THAT(Error(), HasSubstr("there are none"));
  model_ = good;
  model_.points3d.resize(2);
  EXPECT_THAT(Error(), HasSubstr("two photos"));
  model_ = good;
  model_.points3d[7].xyz.x() = std::nan("");
  EXPECT_THAT(Error(), HasSubstr("not a number"));
  model_ = good;
  model_.images[1].points2d[4].xy.x() = std::nan("");
  EXPECT_THAT(Error(), HasSubstr("not a number"));
  model_ = good;
  model_.cameras = {SyntheticModel(1, 0, CameraModel::kFov).cameras[0]};
  EXPECT_THAT(Error(), HasSubstr("FOV cannot be adjusted"));
  model_ = good;
  for (PosedImage& image : model_.images) {
    image.cam_from_world = good.images[0].cam_from_world;
  }
  EXPECT_THAT(Error(), HasSubstr("different places"));
  model_ = good;
  BundleAdjustmentOptions options;
  options.max_iterations = 0;
  EXPECT_THAT(Error(options), HasSubstr("iteration"));
  options = {};
  CancellationToken stop;
  stop.Cancel();
  options.cancellation = &stop;
  EXPECT_THAT(Error(options), HasSubstr("stopped"));
}

}  // namespace
}  // namespace freegs::sfm
