// SPDX-License-Identifier: BSD-3-Clause
// A made-up room with a table of objects, and the cameras that photograph it.
// Everything about it is known, so it serves tests and the demonstration.
//
//   const StatusOr<Scene> scene = BuildScene({.objects = 5});
//   const Photo photo = CastRays(*scene, scene->train[0], pool);

#ifndef FREEGS_TESTS_SCENE_MAKER_SCENE_H_
#define FREEGS_TESTS_SCENE_MAKER_SCENE_H_

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/pinhole.h"
#include "core/status.h"
#include "semantics/geometry/boxes.h"
#include "tests/scene_maker/solid.h"

namespace freegs::scene_maker {

enum class Motion {
  kOrbit,     // Around the table, looking at it.
  kRotation,  // On the spot, turning: no parallax.
};

struct SceneMakerOptions {
  // Photographs to reconstruct from. In an orbit they are at most 9 degrees
  // apart; fewer than 40 cover a part of the circle.
  int views = 40;

  // Photographs from other places on the way, for evaluation.
  int test_views = 8;

  // Size of the photographs in pixels.
  int width = 640;
  int height = 480;

  // Horizontal field of view in degrees.
  double field_of_view = 55;

  // Places objects, draws textures and shakes the camera.
  uint64_t seed = 1;

  // Objects on the table, at most kMaxObjects.
  int objects = 10;

  // False paints everything in one plain colour each.
  bool textured = true;

  Motion motion = Motion::kOrbit;

  Status Check() const;
};

inline constexpr int kMaxObjects = 12;

// The classes of what is not an object, in the order of Solid::background.
inline constexpr std::array<const char*, 3> kBackgroundClasses = {
    "table", "floor", "wall"};

struct SceneObject {
  int id = 0;                      // 1.. as in the instance images.
  std::string label;               // "red striped ball".
  std::string kind;                // "ball".
  semantics::AxisAlignedBox aabb;  // World axes, whole object, metres.
  semantics::OrientedBox obb;      // The object's own axes.
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  // Of its volume.
};

// World frame in metres, z up, floor at 0. View names are those of the files.
struct Scene {
  SceneMakerOptions options;
  std::vector<Solid> solids;
  std::vector<SceneObject> objects;
  std::vector<std::pair<std::string, std::string>> touching;
  std::vector<View> train;
  std::vector<View> test;
  Eigen::Vector3d light = Eigen::Vector3d(1.1, -0.9, 2.6);
  double light_radius = 0.22;
};

StatusOr<Scene> BuildScene(const SceneMakerOptions& options);

// Furnishes the room: floor, walls, table.
void AddRoom(Scene* scene);

// Puts options.objects of the catalogue on the table top; kInternal when they
// find no room there.
Status AddObjects(Scene* scene);

// Fills train and test.
void AddViews(Scene* scene);

// Height and radius of the table top.
inline constexpr double kTableHeight = 0.75;
inline constexpr double kTableRadius = 0.66;

}  // namespace freegs::scene_maker

#endif  // FREEGS_TESTS_SCENE_MAKER_SCENE_H_
