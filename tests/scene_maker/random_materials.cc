// SPDX-License-Identifier: BSD-3-Clause
// Random colours and materials.

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "tests/scene_maker/clutter.h"
#include "tests/scene_maker/noise.h"
#include "tests/scene_maker/textures.h"

namespace freegs::scene_maker {
namespace {

// Stripes across any direction, of two colours.
Texture Stripes(Color first, Color second, float width, float angle) {
  return [=](const SurfacePoint& s) -> Color {
    const float along = std::cos(angle) * s.position.x() +
                        std::sin(angle) * s.position.y() +
                        0.7f * s.position.z();
    const float phase = along / width - std::floor(along / width);
    return phase < 0.5f ? first : second;
  };
}

// Shreds of fur: strong grain along z at the size of hairs.
Texture Fur(Color color, uint32_t seed) {
  return [=](const SurfacePoint& s) -> Color {
    const Eigen::Vector3f hair(
        s.position.x(), s.position.y(), 0.25f * s.position.z());
    const float grain = FractalNoise(hair, 0.006f, 4, s.footprint, seed, 0.8f);
    const float tuft =
        FractalNoise(s.position, 0.03f, 3, s.footprint, seed + 1);
    return color * std::max(0.08f, 1 + 0.9f * grain + 0.4f * tuft);
  };
}

// Irregular cells of up to five colours, as of a mosaic or a patchwork.
Texture Mosaic(std::array<Color, 5> colors,
               uint32_t num_colors,
               float cell,
               uint32_t seed) {
  return [=](const SurfacePoint& s) -> Color {
    const CellHit hit = CellNoise(s.uv.x() / cell, s.uv.y() / cell, seed);
    const float blotch =
        FractalNoise(s.position, 0.3f * cell, 3, s.footprint, seed + 1);
    return colors[hit.id % num_colors] * std::max(0.1f, 1 + 0.25f * blotch);
  };
}

// One material below and another above a ragged border at height 0, such as the
// white belly of a dark animal. `direction` is up.
Texture Zones(Texture below,
              Texture above,
              Eigen::Vector3f direction,
              float raggedness,
              uint32_t seed) {
  return [below = std::move(below),
          above = std::move(above),
          direction,
          raggedness,
          seed](const SurfacePoint& s) -> Color {
    const float border =
        raggedness *
        FractalNoise(s.position, 2 * raggedness, 3, s.footprint, seed);
    return s.position.dot(direction) < border ? below(s) : above(s);
  };
}

// A material that is lighter and darker in large patches, as where light falls
// through a window, or old paint.
Texture Faded(Texture material, float strength, float scale, uint32_t seed) {
  return [material = std::move(material), strength, scale, seed](
             const SurfacePoint& s) -> Color {
    const float light =
        FractalNoise(s.position, scale, 2, s.footprint, seed, 0.4f);
    return material(s) * std::max(0.15f, 1 + strength * light);
  };
}

Texture RandomPlainMaterial(double size, RandomStream* random) {
  const auto seed = static_cast<uint32_t>(random->Index(100000));
  const Color a = RandomColor(random);
  const Color b = RandomColor(random);
  const auto scale = static_cast<float>(size * Between(0.15, 0.6, random));
  switch (random->Index(15)) {
    case 0:
      return Plain(a);
    case 1:
    case 2:
    case 3:
    case 4: {
      const auto blotch = static_cast<float>(size * Between(0.1, 1, random));
      const auto strength = static_cast<float>(Between(0.05, 0.5, random));
      return Worn(a, strength, blotch, seed);
    }
    case 5:
      return Checks(a, b, scale, seed);
    case 6:
      return Marble(a, b, seed);
    case 7:
      return Porcelain(a, seed);
    case 8:
      return Blossoms(a, b, RandomColor(random), seed);
    case 9:
      return Bricks(seed);
    case 10:
      return WoodPlanks(a, b * 0.4f, scale, seed);
    case 11:
      return Stripes(a, b, scale, static_cast<float>(3.1 * random->Uniform()));
    case 12:
      return Fur(a, seed);
    case 13: {
      std::array<Color, 5> colors;
      for (Color& color : colors) color = RandomColor(random);
      return Mosaic(
          colors, 2 + static_cast<uint32_t>(random->Index(4)), scale, seed);
    }
    default:
      return BandedCone(a, b, 2 * scale, seed);
  }
}

}  // namespace

Color RandomColor(RandomStream* random) {
  const double hue = 6 * random->Uniform();
  const double saturation = random->Index(3) == 0
                                ? 0.1 * random->Uniform()
                                : 0.85 * std::pow(random->Uniform(), 1.3);
  const double value = Between(0.15, 0.9, random);
  Color color;
  for (int c = 0; c < 3; ++c) {
    const double k = std::fmod(5 - 2 * c + hue, 6);
    const double v =
        value * (1 - saturation * std::clamp(std::min(k, 4 - k), 0.0, 1.0));
    color[c] = static_cast<float>(std::pow(v, 2.2));
  }
  return color;
}

Texture Worn(Color color, float strength, float scale, uint32_t seed) {
  return [=](const SurfacePoint& s) -> Color {
    const float blotch = FractalNoise(s.position, scale, 5, s.footprint, seed);
    return color * std::max(0.1f, 1 + strength * blotch);
  };
}

Texture RandomFur(double size, RandomStream* random) {
  const auto seed = static_cast<uint32_t>(random->Index(100000));
  const Texture fur = Fur(RandomColor(random), seed);
  if (random->Index(3) == 0) return fur;
  const double angle = 6.28 * random->Uniform();
  const Eigen::Vector3f up(static_cast<float>(0.7 * std::cos(angle)),
                           static_cast<float>(0.7 * std::sin(angle)),
                           static_cast<float>(random->Uniform()));
  const auto ragged = static_cast<float>(size * Between(0.1, 0.4, random));
  const Texture other = Fur(RandomColor(random), seed + 1);
  return Zones(other, fur, up, ragged, seed + 2);
}

Texture RandomMaterial(double size, RandomStream* random) {
  Texture material = RandomPlainMaterial(size, random);
  if (random->Index(3) != 0) return material;
  const auto seed = static_cast<uint32_t>(random->Index(100000));
  const auto scale = static_cast<float>(size * Between(0.5, 2, random));
  const auto strength = static_cast<float>(Between(0.3, 0.9, random));
  return Faded(std::move(material), strength, scale, seed);
}

}  // namespace freegs::scene_maker
