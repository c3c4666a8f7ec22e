// SPDX-License-Identifier: BSD-3-Clause

#include "tests/scene_maker/solid.h"

#include <cmath>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::scene_maker {
namespace {

using Eigen::Vector3d;

std::vector<Solid> SomeSolids() {
  std::vector<Solid> solids(4);
  solids[0].shape = Shape::kBox;
  solids[0].size = {0.3, 0.2, 0.1};
  solids[1].shape = Shape::kEllipsoid;
  solids[1].size = {0.3, 0.2, 0.25};
  solids[2].shape = Shape::kFrustum;
  solids[2].size = {0.2, 0.05, 0.15};
  solids[3].shape = Shape::kTorus;
  solids[3].size = {0.2, 0.06, 0};
  for (Solid& solid : solids) {
    solid.centre = {0.4, -0.1, 0.2};
    solid.rotation = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized())
                         .toRotationMatrix();
  }
  return solids;
}

// Negative inside, zero on the surface, positive outside; not a distance.
double Side(const Solid& solid, const Vector3d& world) {
  const Vector3d p = solid.rotation.transpose() * (world - solid.centre);
  const Vector3d& s = solid.size;
  switch (solid.shape) {
    case Shape::kBox:
      return (p.cwiseAbs() - s).maxCoeff();
    case Shape::kEllipsoid:
      return p.cwiseQuotient(s).norm() - 1;
    case Shape::kFrustum: {
      const double t = (p.z() + s.z()) / (2 * s.z());
      return std::max(std::hypot(p.x(), p.y()) - (s.x() + t * (s.y() - s.x())),
                      std::abs(p.z()) - s.z());
    }
    case Shape::kTorus:
      return std::hypot(std::hypot(p.x(), p.y()) - s.x(), p.z()) - s.y();
  }
  return 0;
}

Vector3d RandomVector(RandomStream* random) {
  return {2 * random->Uniform() - 1,
          2 * random->Uniform() - 1,
          2 * random->Uniform() - 1};
}

TEST(Intersect, FindsTheFirstSurfacePoint) {
  for (const Solid& solid : SomeSolids()) {
    int hits = 0;
    for (uint64_t i = 0; i < 500; ++i) {
      RandomStream random(3, i);
      Ray ray;
      ray.origin = solid.centre + 2 * RandomVector(&random).normalized();
      ray.direction = (solid.centre + 0.4 * RandomVector(&random) - ray.origin)
                          .normalized();
      // Walks along the ray to see where it enters. The solid lies within 0.5
      // of its centre, and the ray starts at a distance of 2 from there.
      double entry = kNoHit;
      constexpr double kStep = 4e-3;
      for (double t = 1.4; t < 2.6; t += kStep) {
        if (Side(solid, ray.origin + t * ray.direction) < 0) {
          entry = t;
          break;
        }
      }
      Hit hit;
      const bool found = Intersect(solid, ray, 0, 10, &hit);
      if (entry < kNoHit) {
        ASSERT_TRUE(found);
        ++hits;
      }
      if (!found) continue;
      const Vector3d point = ray.origin + hit.distance * ray.direction;
      EXPECT_NEAR(Side(solid, point), 0, 1e-5);
      // A grazing hit may lie between two steps.
      EXPECT_LE(hit.distance, entry + 1e-9);
      if (entry < kNoHit) {
        EXPECT_GE(hit.distance, entry - 0.2);
      }
      EXPECT_NEAR(hit.normal.norm(), 1, 1e-9);
      EXPECT_LE(hit.normal.dot(ray.direction), 1e-9);
      EXPECT_NEAR(Distance(solid, ray, 0, 10), hit.distance, 0);
      // The normal leads out of the solid.
      EXPECT_GT(Side(solid, point + 1e-3 * hit.normal), 0);
    }
    EXPECT_GT(hits, 50);
  }
}

TEST(Intersect, BoxesAreRoomsFromInside) {
  Solid room = SomeSolids()[0];
  Hit hit;
  ASSERT_TRUE(
      Intersect(room, {room.centre, room.rotation.col(0)}, 1e-6, 10, &hit));
  EXPECT_NEAR(hit.distance, 0.3, 1e-12);
  EXPECT_EQ(hit.surface.face, 1);
}

TEST(Intersect, KeepsToTheRange) {
  const Solid ball = SomeSolids()[1];
  const Ray ray{ball.centre - 2 * ball.rotation.col(0), ball.rotation.col(0)};
  EXPECT_NEAR(Distance(ball, ray, 0, 10), 1.7, 1e-12);
  EXPECT_NEAR(Distance(ball, ray, 1.8, 10), 2.3, 1e-12);
  EXPECT_EQ(Distance(ball, ray, 0, 1.6), kNoHit);
  EXPECT_EQ(Distance(ball, ray, 2.4, 10), kNoHit);
}

TEST(Support, BoundsTheSurfaceTightly) {
  for (const Solid& solid : SomeSolids()) {
    std::vector<Vector3d> inside;
    for (uint64_t k = 0; k < 20000; ++k) {
      RandomStream random(9, k);
      const Vector3d p = solid.centre + 0.5 * RandomVector(&random);
      if (Side(solid, p) < 0) inside.push_back(p);
    }
    for (uint64_t i = 0; i < 20; ++i) {
      RandomStream random(8, i);
      const Vector3d direction = RandomVector(&random).normalized();
      const double support = Support(solid, direction);
      double reached = -1e9;
      for (const Vector3d& p : inside) {
        reached = std::max(reached, direction.dot(p));
      }
      EXPECT_LE(reached, support + 1e-9);
      EXPECT_GT(reached, support - 0.06);
    }
    EXPECT_GE(BoundingRadius(solid) + 1e-12,
              Support(solid, solid.rotation.col(0)) -
                  solid.centre.dot(solid.rotation.col(0)));
  }
}

TEST(Volume, MatchesCountingPoints) {
  for (const Solid& solid : SomeSolids()) {
    constexpr int kPoints = 100000;
    int inside = 0;
    Vector3d sum = Vector3d::Zero();
    for (uint64_t k = 0; k < kPoints; ++k) {
      RandomStream random(4, k);
      const Vector3d p = solid.centre + 0.4 * RandomVector(&random);
      if (Side(solid, p) >= 0) continue;
      ++inside;
      sum += p;
    }
    const double volume = std::pow(0.8, 3) * inside / kPoints;
    EXPECT_NEAR(Volume(solid), volume, 0.05 * volume);
    EXPECT_LT((Centroid(solid) - sum / inside).norm(), 0.005);
  }
}

}  // namespace
}  // namespace freegs::scene_maker
