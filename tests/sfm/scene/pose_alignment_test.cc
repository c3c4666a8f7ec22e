// SPDX-License-Identifier: BSD-3-Clause
// Alignment of poses under known similarities.

#include "sfm/scene/pose_alignment.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/sfm/synthetic_model.h"

namespace freegs::sfm {
namespace {

Sim3d KnownTransform() {
  Sim3d transform;
  transform.scale = 2.5;
  transform.rotation = Eigen::Quaterniond(0.3, -0.5, 0.7, 0.4).normalized();
  transform.translation = {10, -20, 30};
  return transform;
}

NamedPoses Circle(int count) {
  NamedPoses poses;
  for (const PosedImage& image : SyntheticModel(count, 0).images) {
    poses[image.name] = image.cam_from_world;
  }
  return poses;
}

NamedPoses Line(int count) {
  NamedPoses poses;
  for (int i = 0; i < count; ++i) {
    poses[PhotoName(i)] = LookAt({0.5 * i, 0.25 * i, 3}, {1, 5, 0});
  }
  return poses;
}

NamedPoses Moved(const Sim3d& transform, const NamedPoses& poses) {
  NamedPoses moved;
  for (const auto& [name, pose] : poses) {
    moved[name] = TransformCamera(transform, pose);
  }
  return moved;
}

void ExpectNear(const Sim3d& a, const Sim3d& b, double tolerance) {
  EXPECT_NEAR(a.scale, b.scale, tolerance);
  EXPECT_NEAR(a.rotation.angularDistance(b.rotation), 0, tolerance);
  EXPECT_NEAR((a.translation - b.translation).norm(), 0, 10 * tolerance);
}

TEST(AlignPoses, RecoversASimilarity) {
  for (const int count : {3, 10}) {
    const NamedPoses source = Circle(count);
    const auto result = AlignPoses(source, Moved(KnownTransform(), source));
    ASSERT_TRUE(result.ok()) << result.status().message();
    ExpectNear(result->target_from_source, KnownTransform(), 1e-9);
    EXPECT_LT(result->max_rotation_deg, 1e-5);
    EXPECT_LT(result->max_centre, 1e-9);
    EXPECT_EQ(result->residuals.size(), static_cast<size_t>(count));
  }
}

TEST(AlignPoses, CollinearCentresUseRotations) {
  const NamedPoses source = Line(6);
  const auto result = AlignPoses(source, Moved(KnownTransform(), source));
  ASSERT_TRUE(result.ok()) << result.status().message();
  ExpectNear(result->target_from_source, KnownTransform(), 1e-7);
}

// Cameras along x, which is `sideways` from straight, and the same ones with
// noise: `centre_noise` in the centres, and 0.1 degrees in the orientations.
struct NearlyStraight {
  NamedPoses truth;
  NamedPoses estimated;
};

NearlyStraight NearlyStraightPath(double sideways,
                                  double centre_noise,
                                  uint64_t seed) {
  RandomStream random(seed, 7);
  const auto normal = [&random](double deviation) -> Eigen::Vector3d {
    const double x = random.Normal(), y = random.Normal(), z = random.Normal();
    return deviation * Eigen::Vector3d(x, y, z);
  };
  NearlyStraight path;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector3d centre =
        Eigen::Vector3d(i / 29.0, 0, 0) + normal(sideways);
    Rigid3d pose = LookAt(centre, {0.5, 5, 0});
    path.truth[PhotoName(i)] = pose;
    const Eigen::Vector3d turn = normal(0.1 * M_PI / 180);
    pose.rotation =
        Eigen::AngleAxisd(turn.norm(), turn.normalized()) * pose.rotation;
    pose.translation = -(pose.rotation * (centre + normal(centre_noise)));
    path.estimated[PhotoName(i)] = pose;
  }
  return path;
}

double RotationFaultDeg(const StatusOr<PoseAlignment>& result) {
  if (!result.ok()) return 180;
  return result->target_from_source.rotation.angularDistance(
             KnownTransform().rotation) *
         180 / M_PI;
}

TEST(AlignPoses, RollOfANearlyStraightPathIsThatOfTheCameras) {
  for (uint64_t seed = 0; seed < 10; ++seed) {
    const NearlyStraight path = NearlyStraightPath(1e-3, 1e-3, seed);
    EXPECT_LT(RotationFaultDeg(AlignPoses(path.estimated,
                                          Moved(KnownTransform(), path.truth))),
              0.5)
        << seed;
  }
}

// Each camera is turned by a quarter about its viewing direction, as with other
// image axes.
TEST(AlignPoses, OrientationsOfAnotherConventionYieldToTheCentres) {
  const Eigen::Quaterniond quarter(
      Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
  for (const double sideways : {0.01, 0.3}) {
    NearlyStraight path = NearlyStraightPath(sideways, 1e-4, 1);
    for (auto& [name, pose] : path.estimated) {
      pose = Rigid3d{quarter, Eigen::Vector3d::Zero()} * pose;
    }
    const auto result =
        AlignPoses(path.estimated, Moved(KnownTransform(), path.truth));
    EXPECT_LT(RotationFaultDeg(result), 1) << sideways;
    EXPECT_NEAR(result->median_rotation_deg, 90, 1);
  }
}

// The centres of a ring are as near as they can be by least squares, whatever
// the orientations say.
TEST(AlignPoses, CentresOfARingCountMore) {
  const NamedPoses source = Circle(20);
  for (const double turned_deg : {0.0, 0.5, 90.0}) {
    NamedPoses target = Moved(KnownTransform(), source);
    RandomStream random(5, 8);
    for (auto& [name, pose] : target) {
      const double x = random.Normal(), y = random.Normal(),
                   z = random.Normal();
      const Eigen::Vector3d centre =
          CameraCentre(pose) + 1e-3 * Eigen::Vector3d(x, y, z);
      pose.rotation =
          Eigen::AngleAxisd(turned_deg * M_PI / 180, Eigen::Vector3d::UnitZ()) *
          pose.rotation;
      pose.translation = -(pose.rotation * centre);
    }
    EXPECT_LT(RotationFaultDeg(AlignPoses(source, target)), 0.02) << turned_deg;
  }
}

TEST(AlignPoses, OnlyCommonNamesCount) {
  NamedPoses source = Circle(6);
  NamedPoses target = Moved(KnownTransform(), source);
  source["only in source"] = Rigid3d();
  target["only in target"] = Rigid3d();
  target.erase(PhotoName(0));
  const auto result = AlignPoses(source, target);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->residuals.size(), 5u);
  EXPECT_LT(result->max_centre, 1e-9);
}

TEST(AlignPoses, ResidualsMeasureNoise) {
  const NamedPoses source = Circle(20);
  NamedPoses target = Moved(KnownTransform(), source);
  RandomStream random(5, 5);
  for (auto& [name, pose] : target) {
    const Eigen::Vector3d centre =
        CameraCentre(pose) + 0.01 * Eigen::Vector3d(random.Normal(),
                                                    random.Normal(),
                                                    random.Normal());
    pose.rotation =
        Eigen::AngleAxisd(0.5 * M_PI / 180, Eigen::Vector3d::UnitX()) *
        pose.rotation;
    pose.translation = -(pose.rotation * centre);
  }
  const auto result = AlignPoses(source, target);
  ASSERT_TRUE(result.ok());
  ExpectNear(result->target_from_source, KnownTransform(), 0.01);
  EXPECT_NEAR(result->median_rotation_deg, 0.5, 0.1);
  EXPECT_GT(result->median_centre, 0.003);
  EXPECT_LT(result->max_centre, 0.06);
}

TEST(AlignPoses, RefusesWhatCannotBeAligned) {
  EXPECT_FALSE(AlignPoses({}, {}).ok());
  const NamedPoses two = Circle(2);
  EXPECT_FALSE(AlignPoses(two, two).ok());
  NamedPoses same;
  for (int i = 0; i < 5; ++i) same[PhotoName(i)] = Rigid3d();
  EXPECT_FALSE(AlignPoses(same, same).ok());
  NamedPoses broken = Circle(5);
  broken.begin()->second.translation.x() =
      std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(AlignPoses(broken, Circle(5)).ok());
}

TEST(AlignPoses, NeverMirrors) {
  const NamedPoses source = Circle(10);
  NamedPoses mirrored = source;
  for (auto& [name, pose] : mirrored) {
    const Eigen::Vector3d centre =
        CameraCentre(pose).cwiseProduct(Eigen::Vector3d(1, 1, -1));
    pose.translation = -(pose.rotation * centre);
  }
  const auto result = AlignPoses(source, mirrored);
  ASSERT_TRUE(result.ok()) << result.status().message();
  const Eigen::Matrix3d rotation =
      result->target_from_source.rotation.toRotationMatrix();
  EXPECT_NEAR(rotation.determinant(), 1, 1e-9);
  EXPECT_GT(result->target_from_source.scale, 0);
}

}  // namespace
}  // namespace freegs::sfm
