// SPDX-License-Identifier: BSD-3-Clause

#include "tests/scene_maker/clutter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "tests/scene_maker/textures.h"

namespace freegs::scene_maker {
namespace {

using Eigen::Vector3d;

constexpr double kHalfRoom = 2.4;  // Metres.
constexpr double kRoomTop = 2.8;
constexpr double kWallThickness = 0.05;
constexpr int kThrows = 60;  // Places that are tried for a thing.
constexpr uint64_t kRoomStream = 9100;
constexpr uint64_t kThingStream = 9200;
constexpr uint64_t kScaleStream = 9300;

// Where a thing was put.
struct Standing {
  double x = 0;  // Metres.
  double y = 0;
  double radius = 0;
  double top = 0;     // Height of what can be stood on.
  bool flat = false;  // Whether something can stand on it.
};

double Height(const CatalogueItem& item) {
  double height = 0;
  for (const Solid& part : item.parts) {
    height = std::max(height, Support(part, Vector3d::UnitZ()));
  }
  return height;
}

double Reach(const CatalogueItem& item) {
  double reach = 0;
  for (int i = 0; i < 24; ++i) {
    const double angle = 2 * std::numbers::pi * i / 24;
    const Vector3d direction(std::cos(angle), std::sin(angle), 0);
    for (const Solid& part : item.parts) {
      reach = std::max(reach, Support(part, direction));
    }
  }
  return reach;
}

void PutThing(const CatalogueItem& item,
              const Standing& place,
              double height,
              double turn,
              Scene* scene) {
  const int id = static_cast<int>(scene->objects.size()) + 1;
  SceneObject object;
  object.id = id;
  object.label = "thing " + std::to_string(id);
  object.kind = "thing";
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(turn, Vector3d::UnitZ()).toRotationMatrix();
  object.aabb.min.setConstant(std::numeric_limits<double>::infinity());
  object.aabb.max.setConstant(-std::numeric_limits<double>::infinity());
  double volume = 0;
  for (Solid part : item.parts) {
    part.rotation = rotation * part.rotation;
    part.centre = rotation * part.centre + Vector3d(place.x, place.y, height);
    part.object_id = id;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d unit = Vector3d::Unit(axis);
      object.aabb.max[axis] =
          std::max(object.aabb.max[axis], Support(part, unit));
      object.aabb.min[axis] =
          std::min(object.aabb.min[axis], -Support(part, -unit));
    }
    object.centroid += Volume(part) * Centroid(part);
    volume += Volume(part);
    scene->solids.push_back(std::move(part));
  }
  object.centroid /= volume;
  object.obb.centre = 0.5 * (object.aabb.min + object.aabb.max);
  object.obb.size = object.aabb.max - object.aabb.min;
  scene->objects.push_back(std::move(object));
}

// A framed picture, an object of its own, on the wall at x = -kHalfRoom or
// y = kHalfRoom.
void HangPicture(bool on_y, double along, RandomStream* random, Scene* scene) {
  CatalogueItem item;
  const double a = 0.15 + 0.25 * random->Uniform();
  const double b = 0.15 + 0.2 * random->Uniform();
  const double border = 0.02 + 0.03 * random->Uniform();
  const auto add = [&](const Vector3d& half,
                       const Vector3d& centre,
                       const Texture& texture) {
    Solid solid;
    solid.size = half;
    solid.centre = centre;
    solid.texture = texture;
    item.parts.push_back(std::move(solid));
  };
  add({a, 0.006, b}, {0, 0, 0}, RandomMaterial(a, random));
  const Texture frame = RandomMaterial(border, random);
  for (const double side : {-1.0, 1.0}) {
    add({border, 0.012, b}, {side * a, 0, 0}, frame);
    add({a + border, 0.012, border}, {0, 0, side * b}, frame);
  }
  const Standing place{.x = on_y ? along : -kHalfRoom,
                       .y = on_y ? kHalfRoom : along};
  PutThing(item,
           place,
           1.1 + 0.5 * random->Uniform(),
           on_y ? 0 : std::numbers::pi / 2,
           scene);
}

}  // namespace

double ClutterScale(uint64_t seed) {
  RandomStream random(seed, kScaleStream);
  const bool large = random.Index(3) == 0;
  return large ? 1.4 + random.Uniform() : 1;
}

void AddRandomRoom(Scene* scene) {
  RandomStream random(scene->options.seed, kRoomStream);
  const auto add = [&](Shape shape,
                       const Vector3d& size,
                       const Vector3d& centre,
                       int background,
                       int surface,
                       const Texture& texture) {
    Solid solid;
    solid.shape = shape;
    solid.size = size;
    solid.centre = centre;
    solid.background = background;
    solid.surface = surface;
    solid.texture = texture;
    scene->solids.push_back(std::move(solid));
  };
  constexpr double kMiddle = 0.5 * kRoomTop;
  const Texture walls = RandomMaterial(0.6, &random);
  add(Shape::kBox,
      {kHalfRoom, kHalfRoom, kWallThickness},
      {0, 0, -kWallThickness},
      1,
      1,
      random.Index(2) == 0
          ? FloorWithRug(0, static_cast<uint32_t>(random.Index(1000)))
          : RandomMaterial(0.6, &random));
  add(Shape::kBox,
      {kHalfRoom, kHalfRoom, kWallThickness},
      {0, 0, kRoomTop + kWallThickness},
      2,
      2,
      Plain(FromSrgb(0xe8e4dc)));
  for (int side = 0; side < 4; ++side) {
    const double sign = side % 2 == 0 ? 1 : -1;
    const double out = sign * (kHalfRoom + kWallThickness);
    const bool on_x = side < 2;
    add(Shape::kBox,
        {on_x ? kWallThickness : kHalfRoom,
         on_x ? kHalfRoom : kWallThickness,
         kMiddle},
        {on_x ? out : 0, on_x ? 0 : out, kMiddle},
        2,
        3 + side,
        random.Index(2) == 0 ? walls : RandomMaterial(0.6, &random));
  }
  if (scene->options.subject == Subject::kClutter) {
    constexpr double kHalfTop = 0.018;
    const double radius = kTableRadius * ClutterScale(scene->options.seed);
    const Texture top = RandomMaterial(0.5, &random);
    if (random.Index(2) == 0) {
      add(Shape::kFrustum,
          {radius, radius, kHalfTop},
          {0, 0, kTableHeight - kHalfTop},
          0,
          7,
          top);
    } else {
      add(Shape::kBox,
          {radius, radius * (0.6 + 0.4 * random.Uniform()), kHalfTop},
          {0, 0, kTableHeight - kHalfTop},
          0,
          7,
          top);
    }
    const double leg = 0.5 * (kTableHeight - 2 * kHalfTop);
    add(Shape::kFrustum, {0.1, 0.06, leg}, {0, 0, leg}, 0, 7, top);
  }
  const double z = 2.2 + 0.5 * random.Uniform();
  const double y = 3 * random.Uniform() - 1.5;
  const double x = 3 * random.Uniform() - 1.5;
  scene->light = Vector3d(x, y, z);
}

namespace {

// Looks for a place that is free, on top of a flat thing or, sometimes, right
// beside another. Returns false if there is none.
bool FindPlace(const CatalogueItem& item,
               bool flat,
               double table_radius,
               const std::vector<Standing>& places,
               RandomStream* random,
               Standing* place,
               double* height) {
  const double reach = Reach(item);
  // Closer than this to another thing is touching it or being on it.
  const bool touching = random->Index(3) == 0;
  for (int dart = 0; dart < kThrows; ++dart) {
    const double angle = 2 * std::numbers::pi * random->Uniform();
    const double from_middle =
        0.55 * table_radius * std::sqrt(random->Uniform());
    *place = {.x = from_middle * std::cos(angle),
              .y = from_middle * std::sin(angle),
              .radius = reach,
              .top = 0,
              .flat = flat};
    *height = kTableHeight;
    const Standing* near = nullptr;
    for (const Standing& other : places) {
      const double distance =
          std::hypot(place->x - other.x, place->y - other.y);
      if (other.flat && distance + 0.5 * reach < 0.6 * other.radius) {
        *height = std::max(*height, other.top);  // On top of it.
      } else if (distance < reach + other.radius) {
        near = &other;
      }
    }
    if (near == nullptr) return true;
    if (!touching || near->flat || flat) continue;
    // Moved out until it touches.
    const double away = std::atan2(place->y - near->y, place->x - near->x);
    const double distance = 0.93 * (reach + near->radius);
    place->x = near->x + distance * std::cos(away);
    place->y = near->y + distance * std::sin(away);
    *height = kTableHeight;
    const bool free =
        std::all_of(places.begin(), places.end(), [&](const Standing& other) {
          return &other == near ||
                 std::hypot(place->x - other.x, place->y - other.y) >=
                     reach + other.radius;
        });
    if (free) return true;
  }
  return false;
}

}  // namespace

Status AddClutter(Scene* scene) {
  RandomStream random(scene->options.seed, kThingStream);
  const double scale = ClutterScale(scene->options.seed);
  std::vector<Standing> places;
  const int wanted = scene->options.objects;
  for (int i = 0; i < wanted; ++i) {
    // Flat things come first, so that others come to stand on them.
    const bool flat = i < wanted / 3;
    const double size = scale * (flat ? 0.15 + 0.18 * random.Uniform()
                                      : 0.06 + 0.09 * random.Uniform());
    const CatalogueItem item = RandomThing(size, flat, &random);
    const double turn = 2 * std::numbers::pi * random.Uniform();
    Standing place;
    double height = 0;
    if (!FindPlace(item,
                   flat,
                   scale * kTableRadius,
                   places,
                   &random,
                   &place,
                   &height)) {
      continue;
    }
    place.top = height + Height(item);
    PutThing(item, place, height, turn, scene);
    places.push_back(place);
  }
  if (scene->objects.empty()) {
    return InternalError("nothing fits on the table");
  }
  const int pictures = static_cast<int>(random.Index(4));
  for (int i = 0; i < pictures; ++i) {
    HangPicture(
        i % 2 == 0, -1.2 + 1.2 * (i / 2) + random.Uniform(), &random, scene);
  }
  return Status();
}

}  // namespace freegs::scene_maker
