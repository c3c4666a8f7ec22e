// SPDX-License-Identifier: BSD-3-Clause

#include "stages/film/camera_path.h"

#include <cmath>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::stages {
namespace {

Rigid3d PoseAt(const Eigen::Vector3d& centre, double turn_y) {
  return Inverse(
      {Eigen::Quaterniond(Eigen::AngleAxisd(turn_y, Eigen::Vector3d::UnitY())),
       centre});
}

double Distance(const Rigid3d& a, const Rigid3d& b, double depth) {
  return (CameraCentre(a) - CameraCentre(b)).norm() / depth +
         a.rotation.angularDistance(b.rotation);
}

bool SamePose(const Rigid3d& a, const Rigid3d& b) {
  return Distance(a, b, 1) < 1e-6;
}

// Poses along an arc, at uneven distances, with a hand that shakes.
std::vector<Rigid3d> ShakyPoses(double shake) {
  std::vector<Rigid3d> poses;
  double angle = 0;
  for (size_t k = 0; k < 20; ++k) {
    angle += k % 5 == 0 ? 0.4 : 0.02;
    const Eigen::Vector3d off(RandomUniform(1, 0, k) - 0.5,
                              RandomUniform(1, 1, k) - 0.5,
                              RandomUniform(1, 2, k) - 0.5);
    poses.push_back(
        PoseAt(Eigen::Vector3d(3 * std::cos(angle), 0, 3 * std::sin(angle)) +
                   shake * off,
               -angle));
  }
  return poses;
}

TEST(SmoothPathTest, BeginsAndEndsAtTheFirstAndLastPose) {
  const std::vector<Rigid3d> poses = ShakyPoses(0.1);
  for (const int smoothing : {0, 3}) {
    const auto path =
        SmoothPath(poses, {.num_frames = 50, .smoothing = smoothing});
    ASSERT_EQ(path.size(), 50u);
    EXPECT_TRUE(SamePose(path.front(), poses.front()));
    EXPECT_TRUE(SamePose(path.back(), poses.back()));
  }
}

TEST(SmoothPathTest, ConstantSpeed) {
  const double depth = 4;
  const auto path = SmoothPath(
      ShakyPoses(0), {.num_frames = 400, .smoothing = 0, .depth = depth});
  double total = 0;
  for (size_t k = 1; k < path.size(); ++k) {
    total += Distance(path[k - 1], path[k], depth);
  }
  const double mean = total / 399;
  for (size_t k = 1; k < path.size(); ++k) {
    EXPECT_NEAR(Distance(path[k - 1], path[k], depth), mean, 0.02 * mean) << k;
  }
}

TEST(SmoothPathTest, GoesThroughAllPoses) {
  const std::vector<Rigid3d> poses = ShakyPoses(0.05);
  const auto path = SmoothPath(poses, {.num_frames = 4000});
  for (const Rigid3d& pose : poses) {
    double nearest = 1e9;
    for (const Rigid3d& frame : path) {
      nearest = std::min(nearest, Distance(pose, frame, 5));
    }
    EXPECT_LT(nearest, 2e-3);
  }
}

TEST(SmoothPathTest, SmoothingCalmsTheHand) {
  const auto roughness = [](const std::vector<Rigid3d>& path) {
    double sum = 0;
    for (size_t k = 1; k + 1 < path.size(); ++k) {
      sum += (CameraCentre(path[k - 1]) - 2 * CameraCentre(path[k]) +
              CameraCentre(path[k + 1]))
                 .norm();
    }
    return sum;
  };
  const std::vector<Rigid3d> poses = ShakyPoses(0.1);
  EXPECT_LT(roughness(SmoothPath(poses, {.num_frames = 200, .smoothing = 2})),
            0.6 * roughness(SmoothPath(poses, {.num_frames = 200})));
}

TEST(SmoothPathTest, NoJumpWhereAQuaternionChangesItsSign) {
  std::vector<Rigid3d> poses;
  for (int k = 0; k < 12; ++k) {
    poses.push_back(PoseAt({0, 0, 0}, 0.8 * k));
    if (k % 2 == 1) {
      poses.back().rotation.coeffs() = -poses.back().rotation.coeffs();
    }
  }
  const auto path = SmoothPath(poses, {.num_frames = 200});
  for (size_t k = 1; k < path.size(); ++k) {
    EXPECT_NEAR(Distance(path[k - 1], path[k], 1),
                0.8 * 11 / 199,
                0.05 * 0.8 * 11 / 199);
  }
}

TEST(SmoothPathTest, FewPoses) {
  EXPECT_TRUE(SmoothPath({}, {}).empty());
  const Rigid3d a = PoseAt({1, 2, 3}, 0.3);
  const Rigid3d b = PoseAt({3, 2, 3}, 0.3);
  for (const std::vector<Rigid3d>& same :
       {std::vector<Rigid3d>{a}, std::vector<Rigid3d>{a, a, a}}) {
    const auto path = SmoothPath(same, {.num_frames = 5, .smoothing = 1});
    ASSERT_EQ(path.size(), 5u);
    for (const Rigid3d& frame : path) EXPECT_TRUE(SamePose(frame, a));
  }
  const auto two =
      SmoothPath(std::vector<Rigid3d>{a, b}, {.num_frames = 5, .smoothing = 2});
  ASSERT_EQ(two.size(), 5u);
  for (int k = 0; k < 5; ++k) {
    EXPECT_TRUE(SamePose(two[k], PoseAt({1 + 0.5 * k, 2, 3}, 0.3))) << k;
  }
  EXPECT_EQ(SmoothPath(std::vector<Rigid3d>{a, b}, {.num_frames = 1}).size(),
            1u);
  EXPECT_TRUE(
      SmoothPath(std::vector<Rigid3d>{a, b}, {.num_frames = 0}).empty());
}

TEST(OrbitPathTest, AFullTurnIsClosedAndEven) {
  Orbit orbit;
  orbit.centre = {1, 2, 3};
  orbit.up = Eigen::Vector3d(0.1, -1, 0.2).normalized();
  orbit.radius = 4;
  orbit.height = 1.5;
  const auto path = OrbitPath(orbit, 72);
  ASSERT_EQ(path.size(), 72u);
  for (size_t k = 0; k < path.size(); ++k) {
    const Rigid3d& next = path[(k + 1) % path.size()];
    EXPECT_NEAR((CameraCentre(path[k]) - CameraCentre(next)).norm(),
                2 * 4 * std::sin(std::numbers::pi / 72),
                1e-9);
    // The centre is in the middle of the picture, and `up` is up there.
    const Eigen::Vector3d centre = path[k] * orbit.centre;
    EXPECT_NEAR(centre.head<2>().norm(), 0, 1e-9);
    EXPECT_NEAR(centre.z(), std::hypot(4, 1.5), 1e-9);
    const Eigen::Vector3d up = path[k].rotation * orbit.up;
    EXPECT_NEAR(up.x(), 0, 1e-9);
    EXPECT_LT(up.y(), -0.9);
    EXPECT_NEAR(
        (CameraCentre(path[k]) - orbit.centre).dot(orbit.up), 1.5, 1e-9);
  }
}

TEST(OrbitPathTest, ASwingStaysOnItsArc) {
  Orbit orbit;
  orbit.radius = 2;
  orbit.first_azimuth = 0.5;
  orbit.arc = 1.2;
  const Eigen::Matrix3d axes = OrbitAxes(orbit.up);
  EXPECT_NEAR(axes.determinant(), 1, 1e-12);
  const auto path = OrbitPath(orbit, 100);
  double least = 10;
  double most = -10;
  for (size_t k = 0; k < path.size(); ++k) {
    const Eigen::Vector3d away = axes.transpose() * CameraCentre(path[k]);
    const double azimuth = std::atan2(away.y(), away.x());
    least = std::min(least, azimuth);
    most = std::max(most, azimuth);
    const Rigid3d& next = path[(k + 1) % path.size()];
    EXPECT_LT((CameraCentre(path[k]) - CameraCentre(next)).norm(), 0.1);
  }
  EXPECT_NEAR(least, 0.5, 1e-9);
  EXPECT_NEAR(most, 1.7, 1e-9);
}

TEST(OrbitPathTest, StraightAboveItIsStillLevel) {
  Orbit orbit;
  orbit.radius = 0;
  orbit.height = 3;
  for (const Rigid3d& frame : OrbitPath(orbit, 8)) {
    EXPECT_NEAR(frame.rotation.norm(), 1, 1e-9);
    EXPECT_NEAR((frame * orbit.centre).z(), 3, 1e-9);
  }
}

}  // namespace
}  // namespace freegs::stages
