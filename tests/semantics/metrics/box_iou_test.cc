// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/metrics/box_iou.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::semantics {
namespace {

using Eigen::Vector3d;

OrientedBox Box(const Vector3d& center,
                const Vector3d& size,
                double angle = 0,
                const Vector3d& axis = Vector3d::UnitZ()) {
  return {center,
          size,
          Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix()};
}

bool Contains(const OrientedBox& box, const Vector3d& point) {
  const Vector3d local = box.rotation.transpose() * (point - box.center);
  return (local.cwiseAbs() - 0.5 * box.size).maxCoeff() <= 0;
}

TEST(AxisAlignedBoxIou, KnownOverlaps) {
  const AxisAlignedBox unit{{0, 0, 0}, {1, 1, 1}};
  const AxisAlignedBox shifted{{0.5, 0, 0}, {1.5, 1, 1}};
  const AxisAlignedBox away{{2, 0, 0}, {3, 1, 1}};
  const AxisAlignedBox touching{{1, 0, 0}, {2, 1, 1}};
  EXPECT_DOUBLE_EQ(BoxIou(unit, unit), 1);
  EXPECT_DOUBLE_EQ(BoxIou(unit, shifted), 1.0 / 3);
  EXPECT_DOUBLE_EQ(BoxIou(unit, away), 0);
  EXPECT_DOUBLE_EQ(BoxIou(unit, touching), 0);
}

TEST(AxisAlignedBoxIou, EmptyBoxesOverlapNothing) {
  const AxisAlignedBox unit{{0, 0, 0}, {1, 1, 1}};
  const AxisAlignedBox inverted{{1, 1, 1}, {0, 0, 0}};
  const AxisAlignedBox flat{{0, 0, 0}, {1, 1, 0}};
  EXPECT_EQ(BoxIou(unit, inverted), 0);
  EXPECT_EQ(BoxIou(unit, flat), 0);
  EXPECT_EQ(BoxIou(flat, flat), 0);
}

TEST(OrientedBoxIou, AgreesWithAxisAligned) {
  for (uint64_t i = 0; i < 200; ++i) {
    RandomStream random(5, i);
    const auto vector = [&random] {
      return Vector3d(random.Uniform(), random.Uniform(), random.Uniform());
    };
    const Vector3d ca = vector();
    const Vector3d cb = vector();
    const Vector3d sa = vector() + Vector3d::Constant(0.1);
    const Vector3d sb = vector() + Vector3d::Constant(0.1);
    const AxisAlignedBox a{ca - sa / 2, ca + sa / 2};
    const AxisAlignedBox b{cb - sb / 2, cb + sb / 2};
    EXPECT_NEAR(BoxIou(Box(ca, sa), Box(cb, sb)), BoxIou(a, b), 1e-10);
  }
}

TEST(OrientedBoxIou, SharedFacesAndEdges) {
  const OrientedBox unit = Box({0, 0, 0}, {1, 1, 1});
  EXPECT_NEAR(BoxIou(unit, unit), 1, 1e-12);
  EXPECT_NEAR(BoxIou(unit, Box({0, 0, 0.25}, {1, 1, 0.5})), 0.5, 1e-12);
  EXPECT_NEAR(BoxIou(unit, Box({1, 0, 0}, {1, 1, 1})), 0, 1e-12);
  EXPECT_NEAR(BoxIou(unit, Box({1, 1, 0}, {1, 1, 1})), 0, 1e-12);
  // The same box with its axes renamed.
  const OrientedBox turned = Box({0, 0, 0}, {1, 1, 1}, std::numbers::pi / 2);
  EXPECT_NEAR(BoxIou(unit, turned), 1, 1e-12);
}

TEST(OrientedBoxIou, SquaresAtFortyFiveDegrees) {
  const OrientedBox a = Box({0, 0, 0}, {1, 1, 1});
  const OrientedBox b = Box({0, 0, 0}, {1, 1, 1}, std::numbers::pi / 4);
  // A regular octagon with inradius 1/2.
  const double octagon = 2 * (std::sqrt(2.0) - 1);
  EXPECT_NEAR(IntersectionVolume(a, b), octagon, 1e-12);
  EXPECT_NEAR(BoxIou(a, b), octagon / (2 - octagon), 1e-12);
}

TEST(OrientedBoxIou, OneInsideTheOther) {
  const OrientedBox large = Box({1, 2, 3}, {4, 5, 6}, 0.4, {1, 1, 0});
  const OrientedBox small = Box({1.1, 2, 3}, {0.5, 0.4, 0.3}, 1.2, {0, 1, 3});
  EXPECT_NEAR(IntersectionVolume(large, small), Volume(small), 1e-12);
  EXPECT_NEAR(IntersectionVolume(small, large), Volume(small), 1e-12);
}

TEST(OrientedBoxIou, AgreesWithCountingPoints) {
  for (uint64_t i = 0; i < 5; ++i) {
    RandomStream random(9, i);
    const auto vector = [&random] {
      return Vector3d(random.Uniform(), random.Uniform(), random.Uniform());
    };
    const OrientedBox a = Box(0.3 * vector(),
                              vector() + Vector3d::Ones() * 0.4,
                              3 * random.Uniform(),
                              vector());
    const OrientedBox b = Box(0.3 * vector(),
                              vector() + Vector3d::Ones() * 0.4,
                              3 * random.Uniform(),
                              vector());
    constexpr int kPoints = 200000;
    int both = 0;
    for (int k = 0; k < kPoints; ++k) {
      const Vector3d local =
          a.size.cwiseProduct(vector() - Vector3d::Constant(0.5));
      if (Contains(b, a.center + a.rotation * local)) ++both;
    }
    const double expected = Volume(a) * both / kPoints;
    EXPECT_NEAR(IntersectionVolume(a, b), expected, 0.01 * Volume(a));
    EXPECT_NEAR(IntersectionVolume(a, b), IntersectionVolume(b, a), 1e-10);
  }
}

}  // namespace
}  // namespace freegs::semantics
