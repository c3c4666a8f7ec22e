// SPDX-License-Identifier: BSD-3-Clause
// Things of random shapes.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

#include "tests/scene_maker/clutter.h"
#include "tests/scene_maker/noise.h"
#include "tests/scene_maker/textures.h"
#include "tests/scene_maker/thing_builder.h"

namespace freegs::scene_maker {
namespace {

using Eigen::Vector3d;

// Standing things of several colours: head on a body, cap on a bottle.
void AddFigure(double reach, RandomStream* random, ThingBuilder* build) {
  const double body = reach * Between(0.6, 0.8, random);
  const double head = body * Between(0.6, 0.9, random);
  const Texture coat = random->Index(3) != 0 ? RandomFur(body, random)
                                             : RandomMaterial(body, random);
  const Texture face =
      random->Index(2) == 0 ? coat : RandomMaterial(head, random);
  build->Part(
      Shape::kEllipsoid, {body, body, 1.2 * body}, {0, 0, 1.15 * body}, coat);
  const double neck = 2.2 * body + 0.6 * head;
  build->Part(Shape::kEllipsoid, {head, head, head}, {0, 0, neck}, face);
  const Texture trim = Worn(RandomColor(random), 0.2f, 0.02f, 7);
  for (const double side : {-1.0, 1.0}) {
    build->Part(Shape::kEllipsoid,
                {0.3 * head, 0.2 * head, 0.4 * head},
                {0, side * 0.75 * head, neck + 0.7 * head},
                trim);
    build->Part(Shape::kEllipsoid,
                {0.12 * head, 0.12 * head, 0.12 * head},
                {0.9 * head, side * 0.35 * head, neck + 0.15 * head},
                Plain(FromSrgb(0x101010)));
    build->Part(Shape::kEllipsoid,
                {0.6 * body, 0.3 * body, 0.3 * body},
                {0.6 * body, side * 0.5 * body, 0.3 * body},
                coat);
  }
}

void AddBottle(double reach, RandomStream* random, ThingBuilder* build) {
  const double radius = 0.45 * reach;
  const double half = reach * Between(0.8, 1.3, random);
  const Texture glass = RandomMaterial(radius, random);
  build->Part(Shape::kFrustum, {radius, radius, half}, {0, 0, half}, glass);
  const double shoulder = 0.25 * half;
  build->Part(Shape::kFrustum,
              {radius, 0.35 * radius, shoulder},
              {0, 0, 2 * half + shoulder},
              glass);
  build->Part(Shape::kFrustum,
              {0.4 * radius, 0.38 * radius, 0.2 * half},
              {0, 0, 2 * (half + shoulder) + 0.2 * half},
              Worn(RandomColor(random), 0.1f, 0.02f, 3));
  if (random->Index(2) == 0) {  // A label.
    build->Part(Shape::kFrustum,
                {1.01 * radius, 1.01 * radius, 0.4 * half},
                {0, 0, half},
                RandomMaterial(radius, random));
  }
}

void AddCup(double reach, RandomStream* random, ThingBuilder* build) {
  const double radius = 0.6 * reach;
  const double half = radius * Between(0.7, 1.2, random);
  const Texture glaze = RandomMaterial(radius, random);
  const Color inside = RandomColor(random);
  build->Part(Shape::kFrustum,
              {radius * Between(0.7, 1, random), radius, half},
              {0, 0, half},
              [glaze, inside](const SurfacePoint& s) -> Color {
                return s.face == 2 ? inside : glaze(s);
              });
  build->Part(Shape::kTorus,
              {0.98 * radius, 0.07 * radius, 0},
              {0, 0, 2 * half},
              Worn(RandomColor(random), 0.1f, 0.02f, 5));
  if (random->Index(3) != 0) {
    build->Part(Shape::kTorus,
                {0.6 * half, 0.13 * half, 0},
                {1.1 * radius, 0, half},
                glaze,
                Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitX())
                    .toRotationMatrix());
  }
}

// Thin leaves in all directions above a pot.
void AddPlant(double reach, RandomStream* random, ThingBuilder* build) {
  const double pot = 0.45 * reach;
  build->Part(Shape::kFrustum,
              {0.8 * pot, pot, 0.7 * pot},
              {0, 0, 0.7 * pot},
              RandomMaterial(pot, random));
  const Color green = RandomColor(random);
  const int leaves = 9 + static_cast<int>(random->Index(10));
  for (int i = 0; i < leaves; ++i) {
    const double azimuth = 2 * std::numbers::pi * random->Uniform();
    const double lift = Between(0.2, 1.4, random);
    const double length = reach * Between(0.35, 0.6, random);
    const Eigen::Matrix3d turn =
        (Eigen::AngleAxisd(azimuth, Vector3d::UnitZ()) *
         Eigen::AngleAxisd(-lift, Vector3d::UnitY()) *
         Eigen::AngleAxisd(random->Uniform(), Vector3d::UnitX()))
            .toRotationMatrix();
    const auto shade = static_cast<float>(Between(0.6, 1.2, random));
    build->Part(Shape::kEllipsoid,
                {length, 0.3 * length, 0.03 * length},
                Vector3d(0, 0, 1.5 * pot) + turn * Vector3d(length, 0, 0),
                Worn(green * shade, 0.3f, 0.01f, static_cast<uint32_t>(i)),
                turn);
  }
}

// A tray: a floor with a rim, on which smaller things may stand.
void AddTray(double reach, RandomStream* random, ThingBuilder* build) {
  const double a = reach * Between(0.6, 0.8, random);
  const double b = reach * Between(0.4, 0.6, random);
  const double rim = reach * Between(0.05, 0.2, random);
  const Texture wood = RandomMaterial(a, random);
  build->Part(Shape::kBox, {a, b, 0.004}, {0, 0, 0.004}, wood);
  for (const double side : {-1.0, 1.0}) {
    build->Part(Shape::kBox, {0.006, b, rim}, {side * a, 0, rim}, wood);
    build->Part(Shape::kBox, {a, 0.006, rim}, {0, side * b, rim}, wood);
  }
}

// A seat on thin legs, of which some are joined by rungs.
void AddStool(double reach, RandomStream* random, ThingBuilder* build) {
  const double seat = reach * Between(0.5, 0.7, random);
  const double height = reach * Between(0.9, 1.6, random);
  const double half = 0.08 * reach;
  const double leg = reach * Between(0.05, 0.09, random);
  const Texture wood = RandomMaterial(seat, random);
  const Texture legs =
      random->Index(2) == 0 ? wood : RandomMaterial(leg, random);
  if (random->Index(2) == 0) {
    build->Part(Shape::kFrustum, {seat, seat, half}, {0, 0, height}, wood);
  } else {
    build->Part(Shape::kBox, {seat, seat, half}, {0, 0, height}, wood);
  }
  const bool rungs = random->Index(2) == 0;
  const double out = 0.62 * seat;
  for (const double x : {-out, out}) {
    for (const double y : {-out, out}) {
      build->Part(Shape::kFrustum,
                  {leg, leg, 0.5 * height},
                  {x, y, 0.5 * height},
                  legs);
    }
    if (rungs) {
      build->Part(
          Shape::kBox, {0.5 * leg, out, 0.5 * leg}, {x, 0, 0.4 * height}, legs);
    }
  }
}

void AddFlat(double reach, RandomStream* random, ThingBuilder* build) {
  const double a = reach * Between(0.6, 0.85, random);
  const double b = reach * Between(0.4, 0.6, random);
  switch (random->Index(5)) {
    case 0: {  // A round mat or plate.
      const Texture material = RandomMaterial(a, random);
      build->Part(Shape::kFrustum,
                  {a, a * Between(0.9, 1, random), 0.004},
                  {0, 0, 0.004},
                  material);
      return;
    }
    case 1: {  // A book.
      const double half = Between(0.008, 0.02, random);
      const auto seed = static_cast<uint32_t>(random->Index(1000));
      const Color accent = RandomColor(random);
      const Color cover = RandomColor(random);
      build->Part(Shape::kBox,
                  {a, b, half},
                  {0, 0, half},
                  Book({static_cast<float>(a),
                        static_cast<float>(b),
                        static_cast<float>(half)},
                       cover,
                       accent,
                       seed));
      return;
    }
    case 2: {  // A keyboard: keys on a board.
      const Texture keys = Worn(RandomColor(random), 0.1f, 0.01f, 4);
      build->Part(Shape::kBox,
                  {a, 0.5 * b, 0.006},
                  {0, 0, 0.006},
                  Worn(RandomColor(random), 0.1f, 0.01f, 3));
      for (int x = -4; x <= 4; ++x) {
        for (int y = -1; y <= 1; ++y) {
          build->Part(Shape::kBox,
                      {0.09 * a, 0.12 * b, 0.004},
                      {0.21 * a * x, 0.31 * b * y, 0.016},
                      keys);
        }
      }
      return;
    }
    default: {  // A sheet, a cloth, a mat.
      const double half = Between(0.0008, 0.004, random);
      build->Part(
          Shape::kBox, {a, b, half}, {0, 0, half}, RandomMaterial(a, random));
    }
  }
}

void AddSolid(double reach, RandomStream* random, ThingBuilder* build) {
  const Texture material = RandomMaterial(reach, random);
  switch (random->Index(5)) {
    case 0: {
      const double z = reach * Between(0.2, 0.8, random);
      const double y = reach * Between(0.3, 0.7, random);
      const double x = reach * Between(0.3, 0.7, random);
      build->Part(Shape::kBox, {x, y, z}, {0, 0, z}, material);
      return;
    }
    case 1: {
      const double z = reach * Between(0.3, 0.6, random);
      const double y = reach * Between(0.4, 0.7, random);
      const double x = reach * Between(0.4, 0.9, random);
      build->Part(Shape::kEllipsoid, {x, y, z}, {0, 0, z}, material);
      return;
    }
    case 2: {
      const double radius = reach * Between(0.4, 0.8, random);
      const double half = reach * Between(0.2, 0.9, random);
      build->Part(Shape::kFrustum,
                  {radius, radius * Between(0.2, 1, random), half},
                  {0, 0, half},
                  material);
      return;
    }
    case 3: {
      const double radius = reach * Between(0.4, 0.65, random);
      const double tube = radius * Between(0.2, 0.5, random);
      build->Part(Shape::kTorus, {radius, tube, 0}, {0, 0, tube}, material);
      return;
    }
    default: {  // An open box of another colour inside, a laptop, a lamp.
      const double a = reach * Between(0.5, 0.7, random);
      const double b = reach * Between(0.4, 0.6, random);
      build->Part(Shape::kBox, {a, b, 0.008}, {0, 0, 0.008}, material);
      const Eigen::Matrix3d lid =
          Eigen::AngleAxisd(-Between(0.1, 0.5, random), Vector3d::UnitX())
              .toRotationMatrix();
      build->Part(Shape::kBox,
                  {a, 0.006, 0.8 * b},
                  Vector3d(0, b, 0.012) + lid * Vector3d(0, 0, 0.8 * b),
                  RandomMaterial(reach, random),
                  lid);
    }
  }
}

}  // namespace

CatalogueItem RandomThing(double reach, bool flat, RandomStream* random) {
  ThingBuilder build(random);
  if (flat) {
    AddFlat(reach, random, &build);
    return std::move(build.item);
  }
  switch (random->Index(10)) {
    case 0:
    case 1:
      AddFigure(0.7 * reach, random, &build);
      break;
    case 2:
      AddBottle(reach, random, &build);
      break;
    case 3:
      AddCup(reach, random, &build);
      break;
    case 4:
      AddPlant(reach, random, &build);
      break;
    case 5:
      AddTray(reach, random, &build);
      break;
    case 6:
      AddStool(reach, random, &build);
      break;
    default:
      AddSolid(reach, random, &build);
  }
  return std::move(build.item);
}

}  // namespace freegs::scene_maker
