// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/scene/camera_conversion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/sfm/noisy_scene.h"

namespace freegs::sfm {
namespace {

using testing::HasSubstr;

// The largest distance between images of the same ray, over the image of a.
double Difference(const Camera& a, const Camera& b) {
  double largest = 0;
  for (double x = -1; x <= 1; x += 0.05) {
    for (double y = -1; y <= 1; y += 0.05) {
      const auto in_a = Project(a, {x, y, 1});
      const auto in_b = Project(b, {x, y, 1});
      if (!in_a || !in_b || in_a->x() < 0 || in_a->x() > a.width ||
          in_a->y() < 0 || in_a->y() > a.height) {
        continue;
      }
      largest = std::max(largest, (*in_a - *in_b).norm());
    }
  }
  return largest;
}

TEST(ConvertCamera, ToAModelThatHoldsTheLensIsExact) {
  Camera camera =
      MakeCamera(CameraModel::kSimpleRadial, {500, 322, 237, -0.05});
  camera.id = 9;
  for (const CameraModel model : {CameraModel::kSimpleRadial,
                                  CameraModel::kRadial,
                                  CameraModel::kOpenCv}) {
    const Camera converted = ConvertCamera(camera, model);
    ASSERT_TRUE(converted.Check().ok());
    EXPECT_EQ(converted.id, 9u);
    EXPECT_EQ(converted.model, model);
    EXPECT_LT(Difference(camera, converted), 1e-6);
  }
  const Camera pinhole =
      MakeCamera(CameraModel::kOpenCv, {500, 510, 320, 240, 0, 0, 0, 0});
  EXPECT_LT(Difference(pinhole, ConvertCamera(pinhole, CameraModel::kPinhole)),
            1e-6);
}

TEST(ConvertCamera, OtherModelsComeNear) {
  const Camera camera =
      MakeCamera(CameraModel::kRadial, {500, 320, 240, -0.05, 0.02});
  EXPECT_LT(
      Difference(camera, ConvertCamera(camera, CameraModel::kOpenCvFisheye)),
      1);
  EXPECT_LT(
      Difference(camera, ConvertCamera(camera, CameraModel::kSimpleRadial)), 2);
  EXPECT_LT(
      Difference(camera, ConvertCamera(camera, CameraModel::kSimplePinhole)),
      8);
}

TEST(ConvertCamera, LensesThatTurnBackAreFittedAsFarAsTheyGo) {
  const Camera camera =
      MakeCamera(CameraModel::kRadial, {500, 320, 240, -1.5, 0});
  const Camera converted = ConvertCamera(camera, CameraModel::kSimplePinhole);
  ASSERT_TRUE(converted.Check().ok());
  EXPECT_GT(converted.FocalX(), 300);
  // And one that no ray reaches.
  const Camera absurd =
      MakeCamera(CameraModel::kRadial, {1e-30, 320, 240, -1e30, 0});
  EXPECT_TRUE(ConvertCamera(absurd, CameraModel::kOpenCvFisheye).Check().ok());
}

TEST(CheckLens, TakesRealLenses) {
  for (const Camera& camera :
       {MakeCamera(CameraModel::kSimplePinhole, {500, 320, 240}),
        MakeCamera(CameraModel::kRadial, {500, 320, 240, -0.2, 0.1}),
        MakeCamera(CameraModel::kOpenCv,
                   {500, 506, 320, 240, -0.2, 0.1, 0.004, -0.003}),
        MakeCamera(CameraModel::kOpenCvFisheye,
                   {200, 200, 320, 240, 0.05, -0.03, 0.01, -0.002}),
        // Their images end inside the photo.
        MakeCamera(CameraModel::kRadialFisheye, {200, 320, 240, 0, 0}),
        MakeCamera(CameraModel::kSimpleRadialFisheye, {200, 320, 240, 0})}) {
    EXPECT_TRUE(CheckLens(camera).ok()) << CheckLens(camera).message();
  }
}

TEST(CheckLens, RefusesWhatCannotBe) {
  const auto message = [](CameraModel model, std::vector<double> params) {
    return CheckLens(MakeCamera(model, std::move(params))).message();
  };
  EXPECT_THAT(message(CameraModel::kSimplePinhole, {50, 320, 240}),
              HasSubstr("focal length"));
  EXPECT_THAT(message(CameraModel::kSimplePinhole, {7000, 320, 240}),
              HasSubstr("focal length"));
  EXPECT_THAT(message(CameraModel::kPinhole, {500, 700, 320, 240}),
              HasSubstr("quarter"));
  EXPECT_THAT(message(CameraModel::kSimpleRadial, {500, 320, 240, -0.9}),
              HasSubstr("turns back"));
  EXPECT_THAT(message(CameraModel::kRadial, {500, 320, 240, 0.1, -1.5}),
              HasSubstr("turns back"));
  EXPECT_THAT(message(CameraModel::kOpenCvFisheye,
                      {300, 300, 320, 240, 0.1, -0.6, 0, 0}),
              HasSubstr("turns back"));
}

}  // namespace
}  // namespace freegs::sfm
