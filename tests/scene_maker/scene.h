// SPDX-License-Identifier: BSD-3-Clause
// A made-up room and the cameras that photograph it. It holds a table of
// objects, or furniture, or nothing but a tiled wall. Everything about it is
// known, so it serves tests and the demonstration.
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

// What is photographed.
enum class Subject {
  kTable,      // A table of objects that all differ.
  kChairs,     // Two equal chairs far apart on boards, between plain walls.
  kClutter,    // A table of random things in a random room; see clutter.h.
  kTiles,      // A wall of equal tiles above a floor of boards.
  kStudio,     // The objects of kTable on a round board, and white around it.
  kFurniture,  // Furniture in a room; see furniture.h.
};

enum class Motion {
  kOrbit,     // Around the table, around one chair after the other, along the
              // tiled wall, or from all over the half space above the board.
  kRotation,  // On the spot, turning: no parallax.
};

struct SceneMakerOptions {
  // Photographs to reconstruct from. Around the table they are at most 9
  // degrees apart; fewer than 40 cover a part of the circle, and more than 300
  // go around again at other heights. Around each chair half of them cover 200
  // degrees; along the wall they cover 3.8 metres; of the board they are spread
  // evenly over a half sphere.
  int views = 40;

  // Degrees around the table that the photographs cover; 0 for as many as there
  // are photographs.
  double arc = 0;

  // Photographs from other places on the way, for evaluation.
  int test_views = 8;

  // Size of the photographs in pixels.
  int width = 640;
  int height = 480;

  // Horizontal field of view in degrees.
  double field_of_view = 55;

  // Places objects, draws textures and shakes the camera.
  uint64_t seed = 1;

  // Objects on the table, at most kMaxObjects, or pieces of furniture.
  int objects = 10;

  // False paints everything in one plain colour each.
  bool textured = true;

  Subject subject = Subject::kTable;
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
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  // The volume's.
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

// Adds floor and walls, and the table if it is the subject. A studio has the
// table top only.
void AddRoom(Scene* scene);

// Puts options.objects of the catalogue on the table top, or the chairs on the
// floor. Error: kInternal when the objects find no room on the table.
Status AddObjects(Scene* scene);

// Fills train and test.
void AddViews(Scene* scene);

// Height and radius of the table top.
inline constexpr double kTableHeight = 0.75;
inline constexpr double kTableRadius = 0.66;

// Where a chair stands, and where its front points to: an angle around z, in
// radians from the x axis.
struct ChairPlace {
  double x = 0;  // Metres; y is 0.
  double heading = 0;
};
inline constexpr std::array<ChairPlace, 2> kChairs = {
    {{-1.15, 0.4}, {1.15, 4.2}}};

}  // namespace freegs::scene_maker

#endif  // FREEGS_TESTS_SCENE_MAKER_SCENE_H_
