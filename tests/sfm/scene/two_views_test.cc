// SPDX-License-Identifier: BSD-3-Clause
// Angles and depths of rays, and what a homography explains.

#include "sfm/scene/two_views.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

namespace freegs::sfm {
namespace {

TEST(TwoViews, AngleOfRays) {
  const Eigen::Vector3d z(0, 0, 1);
  EXPECT_NEAR(RayAngleDeg(z, {0, 3, 0}), 90, 1e-12);
  EXPECT_NEAR(RayAngleDeg(z, -5 * z), 180, 1e-12);
  EXPECT_NEAR(RayAngleDeg(z, {1e-9, 0, 1}) / 5.729577951308232e-8, 1, 1e-12);
}

// The ratio of the depths is that of the true ones, and the signs are theirs.
TEST(TwoViews, DepthsWhereRaysMeet) {
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized())
          .toRotationMatrix();
  const Eigen::Vector3d t(0.5, -0.2, 0.1);
  const Eigen::Vector3d ray1(0.2, 0.1, 1);
  for (const double depth : {4.0, -4.0}) {
    const Eigen::Vector3d point2 = rotation * (depth * ray1) + t;
    const Eigen::Vector3d ray2 = point2 / point2.z();
    const RayDepths depths = FindRayDepths(rotation * ray1, ray2, t);
    EXPECT_GT(depths.depth1 * depth, 0);
    EXPECT_NEAR(depths.depth2 / depths.depth1, point2.z() / depth, 1e-9);
  }
}

TEST(TwoViews, ShareThatAHomographyExplains) {
  Eigen::Matrix3d homography;
  homography << 1.1, 0.1, 5, -0.05, 0.9, 3, 1e-4, 2e-4, 1;
  Eigen::Matrix2Xd pixels1(2, 4);
  pixels1 << 10, 200, 300, 50, 20, 30, 400, 90;
  Eigen::Matrix2Xd pixels2 =
      (homography * pixels1.colwise().homogeneous()).colwise().hnormalized();
  EXPECT_EQ(ShareExplained(homography, pixels1, pixels2), 1);
  pixels2(0, 1) += 3.9;
  EXPECT_EQ(ShareExplained(homography, pixels1, pixels2), 1);
  pixels2(1, 2) -= 4.1;
  EXPECT_EQ(ShareExplained(homography, pixels1, pixels2), 0.75);
  EXPECT_EQ(ShareExplained(homography, {}, {}), 0);
}

}  // namespace
}  // namespace freegs::sfm
