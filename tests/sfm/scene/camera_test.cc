// SPDX-License-Identifier: BSD-3-Clause
// Camera models: COLMAP's table, and projection against OpenCV.

#include "sfm/scene/camera.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

#include "core/random.h"
#include "tests/sfm/synthetic_model.h"

namespace freegs::sfm {
namespace {

TEST(CameraModels, NumbersNamesAndCountsAreColmaps) {
  const std::vector<std::pair<std::string, int>> expected = {
      {"SIMPLE_PINHOLE", 3},
      {"PINHOLE", 4},
      {"SIMPLE_RADIAL", 4},
      {"RADIAL", 5},
      {"OPENCV", 8},
      {"OPENCV_FISHEYE", 8},
      {"FULL_OPENCV", 12},
      {"FOV", 5},
      {"SIMPLE_RADIAL_FISHEYE", 4},
      {"RADIAL_FISHEYE", 5},
      {"THIN_PRISM_FISHEYE", 12}};
  ASSERT_EQ(CameraModels().size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    const CameraModelInfo* info = FindCameraModel(static_cast<int>(i));
    ASSERT_NE(info, nullptr);
    EXPECT_EQ(info->name, expected[i].first);
    EXPECT_EQ(info->num_params, expected[i].second);
    EXPECT_EQ(FindCameraModel(std::string_view(expected[i].first)), info);
    EXPECT_EQ(static_cast<size_t>(info->model), i);
    EXPECT_EQ(info->fisheye,
              expected[i].first.find("FISHEYE") != std::string::npos);
  }
  EXPECT_EQ(FindCameraModel(-1), nullptr);
  EXPECT_EQ(FindCameraModel(11), nullptr);
  EXPECT_EQ(FindCameraModel(std::string_view("PANORAMA")), nullptr);
}

// What OpenCV makes of the same point; its pixel centres are at integers, the
// principal point carries the difference.
Eigen::Vector2d OpenCvProject(const Camera& camera, const Eigen::Vector3d& p) {
  const cv::Matx33d k(camera.FocalX(),
                      0,
                      camera.PrincipalX(),
                      0,
                      camera.FocalY(),
                      camera.PrincipalY(),
                      0,
                      0,
                      1);
  const std::vector<cv::Point3d> points = {{p.x(), p.y(), p.z()}};
  const auto d = camera.Distortion();
  std::vector<double> distortion(d.begin(), d.end());
  std::vector<cv::Point2d> pixels;
  const cv::Vec3d zero(0, 0, 0);
  switch (camera.model) {
    case CameraModel::kOpenCvFisheye:
    case CameraModel::kSimpleRadialFisheye:
    case CameraModel::kRadialFisheye:
      distortion.resize(4);
      cv::fisheye::projectPoints(
          points, pixels, zero, zero, cv::Mat(k), cv::Mat(distortion));
      break;
    case CameraModel::kFullOpenCv:
      // Both are k1 k2 p1 p2 k3 k4 k5 k6.
      cv::projectPoints(points, zero, zero, k, distortion, pixels);
      break;
    default:
      distortion.resize(4);
      cv::projectPoints(points, zero, zero, k, distortion, pixels);
  }
  return {pixels[0].x, pixels[0].y};
}

class ProjectTest : public testing::TestWithParam<CameraModel> {};

TEST_P(ProjectTest, AgreesWithOpenCv) {
  Camera camera = SyntheticModel(1, 0, GetParam()).cameras[0];
  RandomStream random(3, static_cast<uint64_t>(GetParam()));
  for (size_t i = GetCameraModel(GetParam()).num_focal + 2;
       i < camera.params.size();
       ++i) {
    camera.params[i] = 0.1 * (random.Uniform() - 0.5);
  }
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d point(
        random.Normal(), random.Normal(), 1 + 3 * random.Uniform());
    const auto pixel = Project(camera, point);
    ASSERT_TRUE(pixel.has_value());
    const Eigen::Vector2d expected = OpenCvProject(camera, point);
    EXPECT_NEAR((*pixel - expected).norm(), 0, 1e-6 * (1 + expected.norm()));
  }
}

INSTANTIATE_TEST_SUITE_P(Models,
                         ProjectTest,
                         testing::Values(CameraModel::kSimplePinhole,
                                         CameraModel::kPinhole,
                                         CameraModel::kSimpleRadial,
                                         CameraModel::kRadial,
                                         CameraModel::kOpenCv,
                                         CameraModel::kOpenCvFisheye,
                                         CameraModel::kFullOpenCv,
                                         CameraModel::kSimpleRadialFisheye,
                                         CameraModel::kRadialFisheye));

TEST(Project, FovFollowsItsEquation) {
  Camera camera = SyntheticModel(1, 0, CameraModel::kFov).cameras[0];
  const double omega = 0.5;
  const Eigen::Vector3d point(0.3, 0.4, 1);
  const double r = 0.5;
  const double factor = std::atan(2 * r * std::tan(omega / 2)) / omega / r;
  const auto pixel = Project(camera, point);
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), 600 * 0.3 * factor + 322, 1e-9);
  EXPECT_NEAR(pixel->y(), 601 * 0.4 * factor + 239, 1e-9);
}

TEST(Project, ThinPrismWithoutPrismIsFisheye) {
  Camera prism =
      SyntheticModel(1, 0, CameraModel::kThinPrismFisheye).cameras[0];
  prism.params = {600, 601, 322, 239, 0.01, 0.02, 0, 0, 0.03, 0.04, 0, 0};
  Camera fisheye = prism;
  fisheye.model = CameraModel::kOpenCvFisheye;
  fisheye.params = {600, 601, 322, 239, 0.01, 0.02, 0.03, 0.04};
  const Eigen::Vector3d point(0.3, -0.7, 1.1);
  EXPECT_NEAR(
      (*Project(prism, point) - *Project(fisheye, point)).norm(), 0, 1e-9);
}

TEST(Project, NothingBehindTheCamera) {
  const Camera camera = SyntheticModel(1, 0).cameras[0];
  EXPECT_FALSE(Project(camera, {0, 0, 0}));
  EXPECT_FALSE(Project(camera, {0, 0, -1}));
  EXPECT_FALSE(Project(camera, {0, 0, std::nan("")}));
}

TEST(Camera, CheckFindsFaults) {
  const Camera good = SyntheticModel(1, 0).cameras[0];
  EXPECT_TRUE(good.Check().ok());
  Camera bad = good;
  bad.params.pop_back();
  EXPECT_FALSE(bad.Check().ok());
  bad = good;
  bad.params[4] = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(bad.Check().ok());
  bad = good;
  bad.params[0] = 0;
  EXPECT_FALSE(bad.Check().ok());
  bad = good;
  bad.height = 0;
  EXPECT_FALSE(bad.Check().ok());
  bad = good;
  bad.width = uint64_t{1} << 40;
  EXPECT_FALSE(bad.Check().ok());
}

TEST(Camera, FocalLengthsAreThoseOfPhotographs) {
  for (const CameraModel model :
       {CameraModel::kSimplePinhole, CameraModel::kPinhole}) {
    Camera camera = SyntheticModel(1, 0, model).cameras[0];
    for (const double focal : {50.0, 640.0, 150000.0}) {
      camera.params[0] = focal;
      EXPECT_TRUE(camera.Check().ok()) << focal;
    }
    for (const double focal : {1e-320, 1e-300, 20.0, 300000.0, 1e300}) {
      camera.params[0] = focal;
      const Status status = camera.Check();
      EXPECT_EQ(status.code(), StatusCode::kBadInput) << focal;
      EXPECT_THAT(status.message(), testing::HasSubstr("focal length of"));
    }
  }
}

TEST(Camera, UndistortedMeansPerspectiveWithZeros) {
  Camera camera = SyntheticModel(1, 0, CameraModel::kFullOpenCv).cameras[0];
  EXPECT_FALSE(camera.IsUndistorted());
  for (size_t i = 4; i < camera.params.size(); ++i) camera.params[i] = 0;
  EXPECT_TRUE(camera.IsUndistorted());
  camera.model = CameraModel::kOpenCvFisheye;
  camera.params.resize(8);
  EXPECT_FALSE(camera.IsUndistorted());
}

TEST(Camera, ResizedScalesProjection) {
  const Camera camera = SyntheticModel(1, 0, CameraModel::kOpenCv).cameras[0];
  const Camera half = camera.Resized(320, 240);
  const Eigen::Vector3d point(0.2, 0.1, 1);
  EXPECT_NEAR(
      (*Project(half, point) - *Project(camera, point) / 2).norm(), 0, 1e-9);
}

}  // namespace
}  // namespace freegs::sfm
