// SPDX-License-Identifier: BSD-3-Clause
// The room, and the whole scene.

#include "tests/scene_maker/scene.h"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "tests/scene_maker/clutter.h"
#include "tests/scene_maker/furniture.h"
#include "tests/scene_maker/textures.h"

namespace freegs::scene_maker {
namespace {

using Eigen::Vector3d;

constexpr Vector3d::Scalar kRoomX = 2.7;  // Half lengths of the room.
constexpr Vector3d::Scalar kRoomY = 2.5;
constexpr double kRoomHeight = 2.9;

int BackgroundClass(const std::string& name) {
  for (size_t i = 0; i < kBackgroundClasses.size(); ++i) {
    if (name == kBackgroundClasses[i]) return static_cast<int>(i);
  }
  return 0;
}

}  // namespace

Status SceneMakerOptions::Check() const {
  if (views < 1 || views > 9999) {
    return InvalidArgumentError("views must be in 1..9999");
  }
  if (test_views < 0 || test_views > 99) {
    return InvalidArgumentError("test_views must be in 0..99");
  }
  if (width < 8 || height < 8 || width > 8192 || height > 8192) {
    return InvalidArgumentError("width and height must be in 8..8192 pixels");
  }
  if (!(field_of_view >= 10 && field_of_view <= 120)) {
    return InvalidArgumentError("field_of_view must be in 10..120 degrees");
  }
  if (!(arc >= 0 && arc <= 360)) {
    return InvalidArgumentError("arc must be in 0..360 degrees");
  }
  if (objects < 1 || objects > kMaxObjects) {
    return InvalidArgumentError("objects must be in 1.." +
                                std::to_string(kMaxObjects));
  }
  return Status();
}

namespace {

constexpr double kThick = 0.05;  // Half thickness of floor, ceiling and walls.

// Adds furniture to a scene, each piece with its rich texture or, in a plain
// scene, in one colour.
class Furnisher {
 public:
  explicit Furnisher(Scene* scene) : scene_(scene) {}

  void Add(Shape shape,
           const Vector3d& size,
           const Vector3d& centre,
           const char* background,
           Texture texture,
           uint32_t plain) {
    Solid solid;
    solid.shape = shape;
    solid.size = size;
    solid.centre = centre;
    solid.background = BackgroundClass(background);
    solid.texture =
        scene_->options.textured ? std::move(texture) : Plain(FromSrgb(plain));
    scene_->solids.push_back(std::move(solid));
  }

 private:
  Scene* scene_;
};

// Walls at +x, -x, +y and -y.
std::array<Texture, 4> WallTextures(Subject subject, uint32_t seed) {
  constexpr auto kHalfX = static_cast<float>(kRoomX);
  constexpr auto kHalfY = static_cast<float>(kRoomY);
  constexpr auto kHalfZ = static_cast<float>(0.5 * kRoomHeight);
  if (subject == Subject::kTable) {
    return {PictureWall(FromSrgb(0x8fa39a), kHalfY, kHalfZ, seed + 1),
            BookShelves(kHalfY, kHalfZ, seed + 3),
            PictureWall(FromSrgb(0xc9a97c), kHalfX, kHalfZ, seed + 2),
            BookShelves(kHalfX, kHalfZ, seed + 4)};
  }
  const Texture wall = subject == Subject::kTiles ? Tiles(0.3f, seed + 9)
                                                  : Plain(FromSrgb(0xd8d4cc));
  return {wall, wall, wall, wall};
}

constexpr double kTop = 0.018;  // Half thickness of the table top.

void AddTableTop(uint32_t seed, Furnisher* room) {
  room->Add(
      Shape::kFrustum,
      {kTableRadius - 0.006, kTableRadius, kTop},
      {0, 0, kTableHeight - kTop},
      "table",
      WoodPlanks(FromSrgb(0xc99a66), FromSrgb(0x6f4324), 0.115f, seed + 6),
      0xa9835c);
}

void AddTableLeg(uint32_t seed, Furnisher* room) {
  const double leg = 0.5 * (kTableHeight - 2 * kTop);
  room->Add(Shape::kFrustum,
            {0.09, 0.055, leg},
            {0, 0, leg},
            "table",
            WoodPlanks(FromSrgb(0x9a6a40), FromSrgb(0x50301a), 0.3f, seed + 7),
            0xa9835c);
  room->Add(Shape::kFrustum,
            {0.34, 0.3, 0.02},
            {0, 0, 0.02},
            "table",
            WoodPlanks(FromSrgb(0x9a6a40), FromSrgb(0x50301a), 0.1f, seed + 8),
            0xa9835c);
}

}  // namespace

void AddRoom(Scene* scene) {
  const Subject subject = scene->options.subject;
  const uint32_t seed = static_cast<uint32_t>(scene->options.seed) * 977u + 5u;
  constexpr double kMiddle = 0.5 * kRoomHeight;
  Furnisher room(scene);
  if (subject == Subject::kStudio) {
    AddTableTop(seed, &room);
    return;
  }
  room.Add(Shape::kBox,
           {kRoomX, kRoomY, kThick},
           {0, 0, -kThick},
           "floor",
           FloorWithRug(subject == Subject::kTable ? 1.75f : 0.0f, seed),
           0xb8a890);
  room.Add(Shape::kBox,
           {kRoomX, kRoomY, kThick},
           {0, 0, kRoomHeight + kThick},
           "wall",
           Plain(FromSrgb(0xe8e4dc)),
           0xe8e4dc);
  const std::array<Texture, 4> walls = WallTextures(subject, seed);
  for (const int side : {0, 1}) {
    const double sign = side == 0 ? 1 : -1;
    room.Add(Shape::kBox,
             {kThick, kRoomY, kMiddle},
             {sign * (kRoomX + kThick), 0, kMiddle},
             "wall",
             walls[static_cast<size_t>(side)],
             0xd8d4cc);
  }
  for (const int side : {0, 1}) {
    const double sign = side == 0 ? 1 : -1;
    room.Add(Shape::kBox,
             {kRoomX, kThick, kMiddle},
             {0, sign * (kRoomY + kThick), kMiddle},
             "wall",
             walls[static_cast<size_t>(2 + side)],
             0xd8d4cc);
  }
  if (subject == Subject::kTable) {
    AddTableTop(seed, &room);
    AddTableLeg(seed, &room);
  }
}

StatusOr<Scene> BuildScene(const SceneMakerOptions& options) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  Scene scene;
  scene.options = options;
  if (options.subject == Subject::kClutter) {
    AddRandomRoom(&scene);
    FREEGS_RETURN_IF_ERROR(AddClutter(&scene));
  } else if (options.subject == Subject::kFurniture) {
    AddRandomRoom(&scene);
    FREEGS_RETURN_IF_ERROR(AddFurniture(&scene));
  } else {
    AddRoom(&scene);
    FREEGS_RETURN_IF_ERROR(AddObjects(&scene));
  }
  AddViews(&scene);
  return scene;
}

}  // namespace freegs::scene_maker
