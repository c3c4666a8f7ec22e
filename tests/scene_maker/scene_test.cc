// SPDX-License-Identifier: BSD-3-Clause

#include "tests/scene_maker/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>

#include "tests/scene_maker/free_space.h"
#include "tests/scene_maker/ray_caster.h"

namespace freegs::scene_maker {
namespace {

using Eigen::Vector3d;

SceneMakerOptions Small() {
  SceneMakerOptions options;
  options.views = 8;
  options.test_views = 2;
  options.width = 80;
  options.height = 60;
  return options;
}

double Angle(const View& a, const View& b) {
  return a.cam_from_world.rotation.angularDistance(b.cam_from_world.rotation) *
         180 / std::numbers::pi;
}

TEST(BuildScene, RefusesBadOptions) {
  SceneMakerOptions options = Small();
  options.objects = kMaxObjects + 1;
  EXPECT_EQ(BuildScene(options).status().code(), StatusCode::kInvalidArgument);
  options = Small();
  options.views = 0;
  EXPECT_FALSE(BuildScene(options).ok());
  options = Small();
  options.width = 4;
  EXPECT_FALSE(BuildScene(options).ok());
}

TEST(BuildScene, EveryNumberOfObjectsFindsRoom) {
  for (int count = 1; count <= kMaxObjects; ++count) {
    for (uint64_t seed = 0; seed < 5; ++seed) {
      SceneMakerOptions options = Small();
      options.objects = count;
      options.seed = seed;
      const auto scene = BuildScene(options);
      ASSERT_TRUE(scene.ok()) << count << " " << seed;
      EXPECT_EQ(scene->objects.size(), static_cast<size_t>(count));
    }
  }
}

TEST(BuildScene, ObjectsStandApartOnTheTable) {
  SceneMakerOptions options = Small();
  options.objects = kMaxObjects;
  const Scene scene = *BuildScene(options);
  EXPECT_EQ(scene.touching.size(), 2u);
  for (const SceneObject& a : scene.objects) {
    EXPECT_GE(a.aabb.min.z(), kTableHeight - 1e-9);
    // The oriented box holds no more than the axis-aligned one must.
    const Vector3d half = a.obb.rotation.cwiseAbs() * a.obb.size / 2;
    EXPECT_TRUE(((a.obb.centre + half) - a.aabb.max).minCoeff() > -1e-9);
    EXPECT_TRUE((a.aabb.min - (a.obb.centre - half)).minCoeff() > -1e-9);
    for (const SceneObject& b : scene.objects) {
      const bool touching = std::any_of(
          scene.touching.begin(), scene.touching.end(), [&](const auto& pair) {
            return (pair.first == a.label && pair.second == b.label) ||
                   (pair.first == b.label && pair.second == a.label);
          });
      if (a.id == b.id || touching) continue;
      // Circles around them are placed 3 cm apart.
      EXPECT_GT(FreeSpace(scene, a.id, b.id), 0.029)
          << a.label << " and " << b.label;
    }
  }
}

TEST(BuildScene, NeighboursInAnOrbitAreClose) {
  SceneMakerOptions options = Small();
  options.views = 40;
  const Scene scene = *BuildScene(options);
  for (size_t i = 0; i < scene.train.size(); ++i) {
    EXPECT_LT(Angle(scene.train[i], scene.train[(i + 1) % 40]), 15);
    // The table's middle is in the picture.
    const Vector3d p =
        scene.train[i].cam_from_world * Vector3d(0, 0, kTableHeight);
    EXPECT_GT(p.z(), 1);
    EXPECT_LT(std::hypot(p.x(), p.y()) / p.z(), 0.15);
  }
}

TEST(BuildScene, RotationHasNoParallax) {
  SceneMakerOptions options = Small();
  options.motion = Motion::kRotation;
  const Scene scene = *BuildScene(options);
  for (const View& view : scene.train) {
    EXPECT_LT((CameraCentre(view.cam_from_world) -
               CameraCentre(scene.train[0].cam_from_world))
                  .norm(),
              1e-9);
  }
  EXPECT_GT(Angle(scene.train[0], scene.train[1]), 3);
}

TEST(BuildScene, TheChairsAreEqualAndEachIsSeenByHalfOfThePhotos) {
  SceneMakerOptions options = Small();
  options.subject = Subject::kChairs;
  const Scene scene = *BuildScene(options);
  ASSERT_EQ(scene.objects.size(), 2u);
  EXPECT_NE(scene.objects[0].label, scene.objects[1].label);
  EXPECT_LT((scene.objects[0].obb.size - scene.objects[1].obb.size).norm(),
            1e-9);
  EXPECT_GT((scene.objects[0].centroid - scene.objects[1].centroid).norm(), 2);
  for (size_t i = 0; i < scene.train.size(); ++i) {
    const Vector3d p =
        scene.train[i].cam_from_world * scene.objects[i / 4].centroid;
    EXPECT_GT(p.z(), 1);
    EXPECT_LT(std::hypot(p.x(), p.y()) / p.z(), 0.3);
  }
}

TEST(BuildScene, ManyPhotosGoAroundAgainAtOtherHeights) {
  SceneMakerOptions options = Small();
  options.views = 301;
  const Scene scene = *BuildScene(options);
  const Vector3d first = CameraCentre(scene.train[0].cam_from_world);
  const Vector3d next = CameraCentre(scene.train[1].cam_from_world);
  const Vector3d above = CameraCentre(scene.train[150].cam_from_world);
  EXPECT_GT((next - first).norm(), 0.02);
  EXPECT_GT(first.head<2>().normalized().dot(above.head<2>().normalized()),
            0.99);
  EXPECT_GT(std::abs(above.z() - first.z()), 0.1);
}

TEST(BuildScene, TheStudioIsWhiteAroundTheBoardAndSeenFromAllOverIt) {
  SceneMakerOptions options = Small();
  options.subject = Subject::kStudio;
  options.width = 60;
  const Scene scene = *BuildScene(options);
  EXPECT_EQ(scene.objects.size(), static_cast<size_t>(options.objects));
  Vector3d mean = Vector3d::Zero();
  for (const View& view : scene.train) {
    EXPECT_GT(CameraCentre(view.cam_from_world).z(), kTableHeight);
    mean += CameraCentre(view.cam_from_world) /
            static_cast<double>(scene.train.size());
  }
  EXPECT_LT(mean.head<2>().norm(), 0.4);  // They stand 1.5 metres away.
  ThreadPool pool(1);
  const Photo photo = CastRays(scene, scene.train.back(), pool);
  for (const int x : {0, 59}) {
    for (const int y : {0, 59}) {
      EXPECT_EQ(photo.color(x, y, 1), 255);
      EXPECT_EQ(photo.instances(x, y), 0);
    }
  }
  EXPECT_LT(photo.color(30, 30, 2), 250);
}

TEST(BuildScene, TheTilesRepeat) {
  SceneMakerOptions options = Small();
  options.subject = Subject::kTiles;
  const Scene scene = *BuildScene(options);
  EXPECT_TRUE(scene.objects.empty());
  EXPECT_GT((CameraCentre(scene.train.back().cam_from_world) -
             CameraCentre(scene.train[0].cam_from_world))
                .norm(),
            3);
  const auto wall = std::find_if(
      scene.solids.begin(), scene.solids.end(), [](const Solid& solid) {
        return solid.centre.y() > 2;
      });
  ASSERT_NE(wall, scene.solids.end());
  SurfacePoint here;
  here.uv = {0.11f, 0.17f};
  SurfacePoint there = here;
  there.uv += Eigen::Vector2f(3 * 0.3f, -2 * 0.3f);
  EXPECT_LT((wall->texture(here) - wall->texture(there)).norm(), 1e-3);
}

TEST(CastRays, IsTheSameForAnyNumberOfThreads) {
  const Scene scene = *BuildScene(Small());
  ThreadPool one(1);
  ThreadPool three(3);
  const Photo a = CastRays(scene, scene.train[0], one);
  const Photo b = CastRays(scene, scene.train[0], three);
  EXPECT_TRUE(std::equal(
      a.color.data(), a.color.data() + a.color.size(), b.color.data()));
  EXPECT_TRUE(std::equal(
      a.depth.data(), a.depth.data() + a.depth.size(), b.depth.data()));
  SceneMakerOptions other = Small();
  other.seed = 2;
  const Scene different = *BuildScene(other);
  const Photo c = CastRays(different, different.train[0], one);
  EXPECT_FALSE(std::equal(
      a.color.data(), a.color.data() + a.color.size(), c.color.data()));
}

// The order in which the arguments of a call are evaluated is not the same with
// GCC and Clang. Where two of them drew random numbers, scenes would differ.
TEST(CastRays, IsTheSameWithEveryCompiler) {
  struct Case {
    Subject subject;
    double places;  // A weighted sum of all places and sizes.
    double color;   // The mean of the first photo.
  };
  const std::array<Case, 4> cases = {
      {{Subject::kTable, 400.30013828840646, 120.211},
       {Subject::kChairs, 504.12355890945395, 110.317},
       {Subject::kClutter, 3038.4972559489429, 122.879},
       {Subject::kFurniture, 833.21649618914591, 115.799}}};
  ThreadPool pool(2);
  for (const Case& expected : cases) {
    SceneMakerOptions options = Small();
    options.subject = expected.subject;
    options.seed = 7;
    const Scene scene = *BuildScene(options);
    double places =
        scene.light.sum() + scene.train[1].cam_from_world.translation.sum();
    double weight = 0;
    for (const Solid& solid : scene.solids) {
      places += ++weight * (solid.size.sum() + solid.centre.sum());
    }
    EXPECT_NEAR(places, expected.places, 1e-6);
    const Photo photo = CastRays(scene, scene.train[0], pool);
    const double color = std::accumulate(
        photo.color.data(), photo.color.data() + photo.color.size(), 0.0);
    EXPECT_NEAR(
        color / static_cast<double>(photo.color.size()), expected.color, 1e-2);
  }
}

TEST(CastRays, TruthOfThePixelsAgrees) {
  SceneMakerOptions options = Small();
  options.width = 160;
  options.height = 120;
  const Scene scene = *BuildScene(options);
  ThreadPool pool(2);
  for (const View& view : scene.test) {
    const Photo photo = CastRays(scene, view, pool);
    const Rigid3d world_from_cam = Inverse(view.cam_from_world);
    for (int y = 0; y < photo.depth.height(); ++y) {
      for (int x = 0; x < photo.depth.width(); ++x) {
        const double z = photo.depth(x, y);
        ASSERT_GT(z, 0);  // The room is closed.
        const Vector3d point =
            world_from_cam *
            Vector3d((x + 0.5 - view.camera.cx) / view.camera.fx * z,
                     (y + 0.5 - view.camera.cy) / view.camera.fy * z,
                     z);
        const int id = photo.instances(x, y);
        ASSERT_EQ(id == 0, photo.background(x, y) != 0);
        if (id == 0) continue;
        // A point of an object lies in both of its boxes.
        const SceneObject& object = scene.objects[static_cast<size_t>(id) - 1];
        EXPECT_GT((point - object.aabb.min).minCoeff(), -1e-4);
        EXPECT_GT((object.aabb.max - point).minCoeff(), -1e-4);
        const Vector3d own =
            object.obb.rotation.transpose() * (point - object.obb.centre);
        EXPECT_LT((own.cwiseAbs() - object.obb.size / 2).maxCoeff(), 1e-4);
      }
    }
  }
}

TEST(CastRays, PlainScenesHaveFewColours) {
  SceneMakerOptions options = Small();
  const Scene rich = *BuildScene(options);
  options.textured = false;
  const Scene plain = *BuildScene(options);
  ThreadPool pool(2);
  const auto roughness = [&pool](const Scene& scene) {
    const Photo photo = CastRays(scene, scene.train[0], pool);
    double sum = 0;
    for (int y = 0; y < 60; ++y) {
      for (int x = 1; x < 80; ++x) {
        sum += std::abs(photo.color(x, y, 1) - photo.color(x - 1, y, 1));
      }
    }
    return sum;
  };
  EXPECT_GT(roughness(rich), 1.5 * roughness(plain));
}

}  // namespace
}  // namespace freegs::scene_maker
