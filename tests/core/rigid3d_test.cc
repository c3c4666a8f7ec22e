// SPDX-License-Identifier: BSD-3-Clause

#include "core/rigid3d.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs {
namespace {

class Rigid3dTest : public ::testing::TestWithParam<int> {
 protected:
  Eigen::Vector3d Point() {
    return {random_.Normal(), random_.Normal(), random_.Normal()};
  }
  Eigen::Quaterniond Rotation() {
    return Eigen::Quaterniond(random_.Normal(),
                              random_.Normal(),
                              random_.Normal(),
                              random_.Normal())
        .normalized();
  }
  Rigid3d Rigid() { return {Rotation(), Point()}; }
  Sim3d Similarity() {
    return {0.2 + 3 * random_.Uniform(), Rotation(), Point()};
  }

  RandomStream random_{static_cast<uint64_t>(GetParam()), 1};
};

constexpr double kTolerance = 1e-12;

TEST_P(Rigid3dTest, MatrixInverseAndComposition) {
  const Rigid3d b_from_a = Rigid();
  const Rigid3d c_from_b = Rigid();
  const Eigen::Vector3d x = Point();
  EXPECT_NEAR((b_from_a.Matrix3x4() * x.homogeneous() - b_from_a * x).norm(),
              0,
              kTolerance);
  EXPECT_NEAR((Inverse(b_from_a) * (b_from_a * x) - x).norm(), 0, kTolerance);
  EXPECT_NEAR(((c_from_b * b_from_a) * x - c_from_b * (b_from_a * x)).norm(),
              0,
              kTolerance);
}

TEST_P(Rigid3dTest, CameraCentreIsTheOriginOfTheCamera) {
  const Rigid3d cam_from_world = Rigid();
  EXPECT_NEAR(
      (cam_from_world * CameraCentre(cam_from_world)).norm(), 0, kTolerance);
}

TEST_P(Rigid3dTest, SimilarityInverse) {
  const Sim3d b_from_a = Similarity();
  const Eigen::Vector3d x = Point();
  EXPECT_NEAR((Inverse(b_from_a) * (b_from_a * x) - x).norm(), 0, 1e-11);
}

// The same camera seen from the other frame: camera coordinates are the same up
// to the change of the length unit.
TEST_P(Rigid3dTest, TransformedCameraSeesTheSame) {
  const Sim3d b_from_a = Similarity();
  const Rigid3d cam_from_a = Rigid();
  const Rigid3d cam_from_b = TransformCamera(b_from_a, cam_from_a);
  const Eigen::Vector3d x_a = Point();
  EXPECT_NEAR(
      (cam_from_b * (b_from_a * x_a) - b_from_a.scale * (cam_from_a * x_a))
          .norm(),
      0,
      1e-11);
  EXPECT_NEAR(
      (CameraCentre(cam_from_b) - b_from_a * CameraCentre(cam_from_a)).norm(),
      0,
      1e-11);
}

INSTANTIATE_TEST_SUITE_P(Random, Rigid3dTest, ::testing::Range(0, 10));

TEST(Rigid3dDefaultTest, IsIdentity) {
  const Eigen::Vector3d x(1, 2, 3);
  EXPECT_EQ(Rigid3d() * x, x);
  EXPECT_EQ(Sim3d() * x, x);
}

}  // namespace
}  // namespace freegs
