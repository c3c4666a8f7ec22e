// SPDX-License-Identifier: BSD-3-Clause

#include "tests/scene_maker/scene.h"

#include <cmath>
#include <numbers>

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
  if (objects < 1 || objects > kMaxObjects) {
    return InvalidArgumentError("objects must be in 1.." +
                                std::to_string(kMaxObjects));
  }
  return Status();
}

void AddRoom(Scene* scene) {
  const SceneMakerOptions& options = scene->options;
  const uint32_t seed = static_cast<uint32_t>(options.seed) * 977u + 5u;
  const auto add = [&](Shape shape,
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
        options.textured ? std::move(texture) : Plain(FromSrgb(plain));
    scene->solids.push_back(std::move(solid));
  };

  const bool table = options.subject == Subject::kTable;
  constexpr double kThick = 0.05;
  const double middle = 0.5 * kRoomHeight;
  const float half_x = static_cast<float>(kRoomX);
  const float half_y = static_cast<float>(kRoomY);
  const float half_z = static_cast<float>(middle);
  add(Shape::kBox,
      {kRoomX, kRoomY, kThick},
      {0, 0, -kThick},
      "floor",
      FloorWithRug(table ? 1.75f : 0.0f, seed),
      0xb8a890);
  add(Shape::kBox,
      {kRoomX, kRoomY, kThick},
      {0, 0, kRoomHeight + kThick},
      "wall",
      Plain(FromSrgb(0xe8e4dc)),
      0xe8e4dc);
  Texture pictures = PictureWall(FromSrgb(0x8fa39a), half_y, half_z, seed + 1);
  Texture more_pictures =
      PictureWall(FromSrgb(0xc9a97c), half_x, half_z, seed + 2);
  Texture shelves = BookShelves(half_y, half_z, seed + 3);
  Texture more_shelves = BookShelves(half_x, half_z, seed + 4);
  if (!table) {
    const Texture wall = options.subject == Subject::kTiles
                             ? Tiles(0.3f, seed + 9)
                             : Plain(FromSrgb(0xd8d4cc));
    pictures = more_pictures = shelves = more_shelves = wall;
  }
  add(Shape::kBox,
      {kThick, kRoomY, middle},
      {kRoomX + kThick, 0, middle},
      "wall",
      pictures,
      0xd8d4cc);
  add(Shape::kBox,
      {kThick, kRoomY, middle},
      {-kRoomX - kThick, 0, middle},
      "wall",
      shelves,
      0xd8d4cc);
  add(Shape::kBox,
      {kRoomX, kThick, middle},
      {0, kRoomY + kThick, middle},
      "wall",
      more_pictures,
      0xd8d4cc);
  add(Shape::kBox,
      {kRoomX, kThick, middle},
      {0, -kRoomY - kThick, middle},
      "wall",
      more_shelves,
      0xd8d4cc);

  if (!table) return;
  constexpr double kTop = 0.018;  // Half thickness of the table top.
  const Texture top =
      WoodPlanks(FromSrgb(0xc99a66), FromSrgb(0x6f4324), 0.115f, seed + 6);
  add(Shape::kFrustum,
      {kTableRadius - 0.006, kTableRadius, kTop},
      {0, 0, kTableHeight - kTop},
      "table",
      top,
      0xa9835c);
  const double leg = 0.5 * (kTableHeight - 2 * kTop);
  add(Shape::kFrustum,
      {0.09, 0.055, leg},
      {0, 0, leg},
      "table",
      WoodPlanks(FromSrgb(0x9a6a40), FromSrgb(0x50301a), 0.3f, seed + 7),
      0xa9835c);
  add(Shape::kFrustum,
      {0.34, 0.3, 0.02},
      {0, 0, 0.02},
      "table",
      WoodPlanks(FromSrgb(0x9a6a40), FromSrgb(0x50301a), 0.1f, seed + 8),
      0xa9835c);
}

StatusOr<Scene> BuildScene(const SceneMakerOptions& options) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  Scene scene;
  scene.options = options;
  AddRoom(&scene);
  FREEGS_RETURN_IF_ERROR(AddObjects(&scene));
  AddViews(&scene);
  return scene;
}

}  // namespace freegs::scene_maker
