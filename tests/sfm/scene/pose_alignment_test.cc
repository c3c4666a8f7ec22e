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
