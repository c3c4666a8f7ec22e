// SPDX-License-Identifier: BSD-3-Clause
// What the objects are made of.

#include "tests/scene_maker/catalogue.h"

#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

#include "tests/scene_maker/textures.h"

namespace freegs::scene_maker {
namespace {

using Eigen::Vector3d;

// Collects items; each part takes a rich texture or its plain colour.
class Builder {
 public:
  explicit Builder(bool textured) : textured_(textured) {}

  void Item(std::string label, std::string kind, Place place = Place::kAlone) {
    items_.push_back({std::move(label), std::move(kind), place, {}});
  }

  void Part(Shape shape,
            const Vector3d& size,
            const Vector3d& centre,
            Texture texture,
            uint32_t plain,
            float gloss,
            const Eigen::Matrix3d& rotation = Eigen::Matrix3d::Identity()) {
    Solid solid;
    solid.shape = shape;
    solid.size = size;
    solid.centre = centre;
    solid.rotation = rotation;
    solid.texture = textured_ ? std::move(texture) : Plain(FromSrgb(plain));
    solid.gloss = gloss;
    items_.back().parts.push_back(std::move(solid));
  }

  std::vector<CatalogueItem> Take() { return std::move(items_); }

 private:
  bool textured_;
  std::vector<CatalogueItem> items_;
};

Eigen::Vector3f Single(const Vector3d& v) { return v.cast<float>(); }

// Crate and block side by side, and a mug on a book.
void AddGroups(uint32_t seed, Builder* build) {
  const Vector3d crate(0.1, 0.085, 0.065);
  build->Item("wooden crate", "crate");
  build->Part(Shape::kBox,
              crate,
              {0, 0, crate.z()},
              Crate(Single(crate), seed + 1),
              0xb98a50,
              0);

  const Vector3d block(0.052, 0.075, 0.048);
  build->Item("brick block", "block", Place::kBeside);
  build->Part(
      Shape::kBox, block, {0, 0, block.z()}, Bricks(seed + 2), 0x9a4a38, 0);

  const Vector3d book(0.085, 0.12, 0.019);
  build->Item("green book", "book");
  build->Part(
      Shape::kBox,
      book,
      {0, 0, book.z()},
      Book(Single(book), FromSrgb(0x2f7d4f), FromSrgb(0xe8c45a), seed + 3),
      0x2f7d4f,
      0.05f);

  // A mug: body, rounded rim, coffee just below it, a handle sunk in the side.
  const Texture mug = Blossoms(
      FromSrgb(0x2f5fa8), FromSrgb(0xf4ead2), FromSrgb(0xe6a93c), seed + 4);
  build->Item("blue mug", "mug", Place::kOnTop);
  build->Part(
      Shape::kFrustum,
      {0.036, 0.042, 0.048},
      {0, 0, 0.048},
      [mug](const SurfacePoint& s) -> Color {
        if (s.face != 2) return mug(s);
        return FromSrgb(0x3b2213) *
               (1 + 0.5f * std::sin(220 * s.uv.norm()) *
                        std::cos(3 * std::atan2(s.uv.y(), s.uv.x())));
      },
      0x2f5fa8,
      0.25f);
  build->Part(Shape::kTorus,
              {0.0415, 0.0042, 0},
              {0, 0, 0.097},
              Plain(FromSrgb(0xe9e2cf)),
              0x2f5fa8,
              0.3f);
  build->Part(
      Shape::kTorus,
      {0.026, 0.0065, 0},
      {0.05, 0, 0.052},
      Blossoms(
          FromSrgb(0x2f5fa8), FromSrgb(0xf4ead2), FromSrgb(0xe6a93c), seed + 4),
      0x2f5fa8,
      0.25f,
      Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitX())
          .toRotationMatrix());
}

void AddRoundThings(uint32_t seed, Builder* build) {
  const Eigen::Matrix3d tilt =
      Eigen::AngleAxisd(0.5, Vector3d(1, 0.4, 0).normalized())
          .toRotationMatrix();
  constexpr double kBall = 0.066;
  build->Item("red striped ball", "ball");
  build->Part(Shape::kEllipsoid,
              {kBall, kBall, kBall},
              {0, 0, kBall},
              StripedBall(FromSrgb(0xcc2f2a), FromSrgb(0xf3ecdc), 4, seed + 5),
              0xcc2f2a,
              0.2f,
              tilt);

  // A vase: belly, neck, lip.
  const Texture glaze = Porcelain(FromSrgb(0x27519c), seed + 6);
  build->Item("white vase", "vase");
  build->Part(Shape::kEllipsoid,
              {0.066, 0.066, 0.085},
              {0, 0, 0.085},
              glaze,
              0xeeeae0,
              0.25f);
  build->Part(Shape::kFrustum,
              {0.043, 0.043, 0.006},
              {0, 0, 0.006},
              glaze,
              0xeeeae0,
              0.1f);
  build->Part(
      Shape::kFrustum,
      {0.032, 0.027, 0.035},
      {0, 0, 0.18},
      [glaze](const SurfacePoint& s) -> Color {
        return s.face == 2 ? FromSrgb(0x1a1714) : glaze(s);
      },
      0xeeeae0,
      0.25f);
  build->Part(
      Shape::kTorus, {0.029, 0.006, 0}, {0, 0, 0.22}, glaze, 0xeeeae0, 0.25f);

  build->Item("pink doughnut", "doughnut");
  build->Part(Shape::kTorus,
              {0.058, 0.029, 0},
              {0, 0, 0.029},
              Doughnut(FromSrgb(0xee7fa6), seed + 7),
              0xee7fa6,
              0.12f);

  build->Item("blue striped ball", "ball");
  build->Part(Shape::kEllipsoid,
              {kBall, kBall, kBall},
              {0, 0, kBall},
              StripedBall(FromSrgb(0x2459a8), FromSrgb(0xf2c53d), 4, seed + 8),
              0x2459a8,
              0.2f,
              tilt.transpose());
}

void AddOtherThings(uint32_t seed, Builder* build) {
  build->Item("orange cone", "cone");
  build->Part(
      Shape::kFrustum,
      {0.064, 0.014, 0.09},
      {0, 0, 0.1},
      BandedCone(FromSrgb(0xe8681f), FromSrgb(0xf0ede4), 0.18f, seed + 9),
      0xe8681f,
      0.05f);
  build->Part(
      Shape::kBox,
      {0.075, 0.075, 0.005},
      {0, 0, 0.005},
      BandedCone(FromSrgb(0xc9551a), FromSrgb(0xc9551a), 0.01f, seed + 9),
      0xe8681f,
      0.05f);

  constexpr double kCube = 0.05;
  build->Item("checkered cube", "cube");
  build->Part(Shape::kBox,
              {kCube, kCube, kCube},
              {0, 0, kCube},
              Checks(FromSrgb(0xf0e8d4), FromSrgb(0x5a3a86), 0.025f, seed + 10),
              0x8a6aa8,
              0.08f);

  build->Item("yellow can", "can");
  build->Part(Shape::kFrustum,
              {0.042, 0.042, 0.062},
              {0, 0, 0.062},
              TinCan(FromSrgb(0xf0c232), FromSrgb(0xb3372c), 0.062f, seed + 11),
              0xf0c232,
              0.2f);

  build->Item("green marble egg", "egg");
  build->Part(Shape::kEllipsoid,
              {0.068, 0.048, 0.048},
              {0, 0, 0.048},
              Marble(FromSrgb(0x5d9b7c), FromSrgb(0xe9f0e2), seed + 12),
              0x5d9b7c,
              0.3f);
}

}  // namespace

std::vector<CatalogueItem> MakeCatalogue(bool textured, uint32_t seed) {
  Builder build(textured);
  AddGroups(seed, &build);
  AddRoundThings(seed, &build);
  AddOtherThings(seed, &build);
  return build.Take();
}

CatalogueItem MakeChair(bool textured, uint32_t seed) {
  Builder build(textured);
  const Texture wood =
      WoodPlanks(FromSrgb(0xc08a52), FromSrgb(0x5a3418), 0.11f, seed);
  const Texture cloth =
      Checks(FromSrgb(0xd8c8a0), FromSrgb(0x7a2f36), 0.045f, seed + 1);
  const auto board = [&](const Vector3d& half, const Vector3d& centre) {
    build.Part(Shape::kBox, half, centre, wood, 0xa9794a, 0);
  };
  build.Item("chair", "chair");
  for (const double x : {-0.19, 0.19}) {
    for (const double y : {-0.19, 0.19}) {
      board({0.02, 0.02, 0.22}, {x, y, 0.22});
    }
  }
  board({0.22, 0.22, 0.015}, {0, 0, 0.455});
  build.Part(Shape::kBox, {0.2, 0.2, 0.015}, {0, 0, 0.485}, cloth, 0x8a4a4a, 0);
  for (const double y : {-0.19, 0.19}) {
    board({0.018, 0.018, 0.195}, {-0.2, y, 0.665});
  }
  board({0.012, 0.19, 0.06}, {-0.2, 0, 0.79});
  board({0.012, 0.19, 0.035}, {-0.2, 0, 0.62});
  return build.Take()[0];
}

}  // namespace freegs::scene_maker
