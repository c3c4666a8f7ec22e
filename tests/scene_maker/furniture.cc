// SPDX-License-Identifier: BSD-3-Clause

#include "tests/scene_maker/furniture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "tests/scene_maker/clutter.h"
#include "tests/scene_maker/placement.h"
#include "tests/scene_maker/textures.h"
#include "tests/scene_maker/thing_builder.h"

namespace freegs::scene_maker {
namespace {

using Eigen::Vector3d;

constexpr uint64_t kFurnitureStream = 9400;
constexpr double kFloorRadius = 1.15;  // Where pieces stand (metres).
constexpr double kFreeFloor = 0.06;
constexpr int kFurnitureThrows = 200;

struct NamedColor {
  const char* name;
  uint32_t srgb;
};
constexpr std::array<NamedColor, 9> kColors = {{{"red", 0xc03028},
                                                {"green", 0x3a8a48},
                                                {"blue", 0x2c58a8},
                                                {"yellow", 0xe6c030},
                                                {"orange", 0xe07820},
                                                {"purple", 0x74429a},
                                                {"pink", 0xe888a8},
                                                {"brown", 0x7a5030},
                                                {"white", 0xe8e6e0}}};

// A surface of the colour, worn or of boards.
Texture Surface(uint32_t srgb, RandomStream* random) {
  const auto seed = static_cast<uint32_t>(random->Index(100000));
  const Color color = FromSrgb(srgb);
  if (random->Index(3) == 0) return WoodPlanks(color, 0.5f * color, 0.1f, seed);
  return Worn(color, 0.25f, 0.05f, seed);
}

// What legs, poles and feet are of: wood, metal, or any colour.
Texture FrameSurface(RandomStream* random) {
  constexpr std::array<uint32_t, 4> kFrames = {
      0xa87848, 0x503018, 0x282828, 0xb0b0b0};
  const size_t choice = random->Index(kFrames.size() + 1);
  return Surface(choice < kFrames.size()
                     ? kFrames[choice]
                     : kColors[random->Index(kColors.size())].srgb,
                 random);
}

// Four legs `out` from the axis, which end at `height`.
void BuildLegs(double out,
               double height,
               const Texture& frame,
               RandomStream* random,
               ThingBuilder* build) {
  const double thick = Between(0.014, 0.028, random);
  for (const double x : {-out, out}) {
    for (const double y : {-out, out}) {
      build->Part(Shape::kBox,
                  {thick, thick, 0.5 * height},
                  {x, y, 0.5 * height},
                  frame);
    }
  }
}

// A seat or a table top, round or square, which ends at `height`. Returns how
// far from the axis legs stand.
double BuildTop(double radius,
                double height,
                const Texture& surface,
                RandomStream* random,
                ThingBuilder* build) {
  const double half = Between(0.012, 0.03, random);
  if (random->Index(2) == 0) {
    build->Part(Shape::kFrustum,
                {radius, radius, half},
                {0, 0, height - half},
                surface);
    return 0.6 * radius;
  }
  build->Part(
      Shape::kBox, {radius, radius, half}, {0, 0, height - half}, surface);
  return 0.85 * radius;
}

void BuildStool(const Texture& surface,
                RandomStream* random,
                ThingBuilder* build) {
  const double height = Between(0.4, 0.7, random);
  const Texture frame = FrameSurface(random);
  const double out =
      BuildTop(Between(0.15, 0.2, random), height, surface, random, build);
  BuildLegs(out, height - 0.03, frame, random, build);
  if (random->Index(2) == 0) {
    build->Part(Shape::kTorus,
                {std::numbers::sqrt2 * out, 0.012, 0},
                {0, 0, 0.4 * height},
                frame);
  }
}

void BuildChair(const Texture& surface,
                RandomStream* random,
                ThingBuilder* build) {
  const double height = Between(0.4, 0.48, random);
  const double back = Between(0.3, 0.45, random);
  const double half = Between(0.18, 0.22, random);
  const Texture frame = FrameSurface(random);
  build->Part(
      Shape::kBox, {half, half, 0.018}, {0, 0, height - 0.018}, surface);
  BuildLegs(0.85 * half, height - 0.03, frame, random, build);
  for (const double y : {-0.85 * half, 0.85 * half}) {
    build->Part(Shape::kBox,
                {0.018, 0.018, 0.5 * back},
                {-0.9 * half, y, height + 0.5 * back},
                frame);
  }
  build->Part(Shape::kBox,
              {0.012, 0.85 * half, 0.25 * back},
              {-0.9 * half, 0, height + 0.72 * back},
              surface);
}

void BuildTable(const Texture& surface,
                RandomStream* random,
                ThingBuilder* build) {
  const double height = Between(0.4, 0.65, random);
  const Texture frame = FrameSurface(random);
  const double radius = Between(0.26, 0.36, random);
  const double out = BuildTop(radius, height, surface, random, build);
  if (random->Index(2) == 0) {
    BuildLegs(out, height - 0.03, frame, random, build);
    return;
  }
  build->Part(Shape::kFrustum,
              {0.04, 0.03, 0.5 * height - 0.015},
              {0, 0, 0.5 * height - 0.015},
              frame);
  build->Part(Shape::kFrustum,
              {0.7 * radius, 0.6 * radius, 0.012},
              {0, 0, 0.012},
              frame);
}

void BuildLamp(const Texture& surface,
               RandomStream* random,
               ThingBuilder* build) {
  const double height = Between(0.7, 1.2, random);
  const Texture frame = FrameSurface(random);
  const double shade = Between(0.12, 0.18, random);
  build->Part(Shape::kFrustum, {0.15, 0.13, 0.012}, {0, 0, 0.012}, frame);
  build->Part(Shape::kFrustum,
              {0.016, 0.016, 0.5 * height},
              {0, 0, 0.5 * height},
              frame);
  build->Part(Shape::kFrustum,
              {shade, Between(0.4, 0.8, random) * shade, 0.11},
              {0, 0, height},
              surface);
}

}  // namespace

CatalogueItem RandomFurniture(const std::string& kind, RandomStream* random) {
  ThingBuilder build(random);
  const NamedColor& color = kColors[random->Index(kColors.size())];
  const Texture surface = Surface(color.srgb, random);
  if (kind == "stool") {
    BuildStool(surface, random, &build);
  } else if (kind == "chair") {
    BuildChair(surface, random, &build);
  } else if (kind == "table") {
    BuildTable(surface, random, &build);
  } else if (kind == "lamp") {
    BuildLamp(surface, random, &build);
  } else if (kind == "box") {
    const double z = Between(0.1, 0.2, random);
    const double y = Between(0.12, 0.2, random);
    const double x = Between(0.12, 0.2, random);
    build.Part(Shape::kBox, {x, y, z}, {0, 0, z}, surface);
  } else {
    const double radius = Between(0.12, 0.18, random);
    build.Part(
        Shape::kEllipsoid, {radius, radius, radius}, {0, 0, radius}, surface);
  }
  build.item.kind = kind;
  build.item.label = std::string(color.name) + " " + kind;
  return std::move(build.item);
}

Status AddFurniture(Scene* scene) {
  RandomStream random(scene->options.seed, kFurnitureStream);
  constexpr std::array<const char*, 8> kKinds = {
      "stool", "chair", "lamp", "table", "stool", "box", "chair", "ball"};
  struct Standing {
    Eigen::Vector2d position;
    double radius = 0;
  };
  std::vector<Standing> places;
  for (int i = 0; i < scene->options.objects; ++i) {
    const CatalogueItem item = RandomFurniture(
        kKinds[static_cast<size_t>(i) % kKinds.size()], &random);
    // Words that stand for two things tell nothing.
    const bool known = std::any_of(
        scene->objects.begin(),
        scene->objects.end(),
        [&](const SceneObject& object) { return object.label == item.label; });
    const double radius = ItemRadius(item);
    const double turn = 2 * std::numbers::pi * random.Uniform();
    for (int dart = 0; dart < kFurnitureThrows && !known; ++dart) {
      const double angle = 2 * std::numbers::pi * random.Uniform();
      const double distance =
          (kFloorRadius - radius) * std::sqrt(random.Uniform());
      const Eigen::Vector2d position(distance * std::cos(angle),
                                     distance * std::sin(angle));
      const bool free =
          std::all_of(places.begin(), places.end(), [&](const Standing& other) {
            return (position - other.position).norm() >
                   radius + other.radius + kFreeFloor;
          });
      if (!free) continue;
      places.push_back({position, radius});
      const int id = static_cast<int>(scene->objects.size()) + 1;
      SceneObject object;
      PutDown(item,
              Eigen::AngleAxisd(turn, Vector3d::UnitZ()).toRotationMatrix(),
              {position.x(), position.y(), 0},
              id,
              &object,
              &scene->solids);
      scene->objects.push_back(std::move(object));
      break;
    }
  }
  if (scene->objects.empty()) {
    return InternalError("nothing fits on the floor");
  }
  return Status();
}

}  // namespace freegs::scene_maker
