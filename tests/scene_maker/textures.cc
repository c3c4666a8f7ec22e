// SPDX-License-Identifier: BSD-3-Clause

#include "tests/scene_maker/textures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/scene_maker/noise.h"

namespace freegs::scene_maker {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float kPi = std::numbers::pi_v<float>;

Color Mix(const Color& a, const Color& b, float t) { return a + t * (b - a); }

// Scuffs and stains at all scales: a factor about 1.
float Wear(const SurfacePoint& s, float strength, uint32_t seed) {
  const float broad = FractalNoise(s.position, 0.05f, 6, s.footprint, seed);
  const float spots =
      FractalNoise(s.position, 0.012f, 3, s.footprint, seed + 40, 0.8f);
  const float speck = SmoothStep(0.45f, 0.6f, spots);
  return std::max(0.1f, 1 + strength * broad - 1.3f * strength * speck);
}

// How much a stroke of half width `half` at distance `d` covers, with an edge
// as soft as a pixel.
float Stroke(float d, float half, float footprint) {
  return 1 - SmoothStep(half - 0.4f * footprint, half + 0.4f * footprint, d);
}

// A line of random letters of the given height, baseline at v = 0, starting
// at u = 0: 1 on ink. `length` letters, with gaps between words.
float Letters(Vector2f uv, float height, int length, uint32_t seed) {
  const float unit = height / 7;
  const int column = static_cast<int>(std::floor(uv.x() / (6 * unit)));
  const int x = static_cast<int>(std::floor(uv.x() / unit)) - 6 * column;
  const int y = static_cast<int>(std::floor(uv.y() / unit));
  if (column < 0 || column >= length || y < 0 || y > 6 || x > 4) return 0;
  const uint32_t letter = HashCell(seed, column, 7);
  if (letter % 6 == 0) return 0;
  return LetterBit(letter, x, y) ? 1 : 0;
}

}  // namespace

Color FromSrgb(uint32_t rgb) {
  Color color;
  for (int i = 0; i < 3; ++i) {
    const float v = static_cast<float>((rgb >> (16 - 8 * i)) & 255) / 255;
    color[i] = std::pow(v, 2.2f);
  }
  return color;
}

bool LetterBit(uint32_t letter, int x, int y) {
  // Half are symmetric, all have a stem: enough to look like some alphabet.
  if (x == 0) return (letter & 1) != 0 || y % 3 == 0;
  const int column = (letter & 2) != 0 ? std::min(x, 4 - x) : x;
  if (y == 0 || y == 3 || y == 6) {
    return (HashCell(letter, 0, y) % 4) != 0;
  }
  return (HashCell(letter, column, y / 2) % 3) == 0;
}

Texture Plain(Color color) {
  return [color](const SurfacePoint&) { return color; };
}

Texture WoodPlanks(Color light, Color dark, float plank_width, uint32_t seed) {
  return [=](const SurfacePoint& s) -> Color {
    const float across =
        std::abs(s.normal.y()) > 0.7f ? s.position.z() : s.position.y();
    const float plank = std::floor(across / plank_width);
    const int index = static_cast<int>(plank);
    const float shift = 7.3f * HashUnit(seed, index, 1);
    const float in_plank = across / plank_width - plank;
    // Rings of a trunk cut lengthwise: noise drawn out along x, wavy.
    const Vector3f stretched(
        s.position.x() * 0.12f + shift, across + shift, s.position.z());
    const float bend = FractalNoise(stretched, 0.06f, 3, s.footprint, seed);
    const float rings = 0.5f + 0.5f * std::sin(260 * (across + 0.05f * bend) +
                                               9 * HashUnit(seed, index, 2));
    const float fibre =
        FractalNoise({s.position.x() * 0.08f + shift, across, s.position.z()},
                     0.006f,
                     3,
                     s.footprint,
                     seed + 20);
    const float stain =
        FractalNoise(s.position, 0.11f, 4, s.footprint, seed + 30);
    float t = 0.32f + 0.22f * rings + 0.3f * fibre + 0.3f * stain +
              0.34f * (HashUnit(seed, index, 3) - 0.5f);
    // Knots.
    const CellHit knot =
        CellNoise(s.position.x() * 5 + shift, across * 9 + shift, seed + 60);
    if (knot.id % 5 == 0) {
      t += 0.9f * (1 - SmoothStep(0.03f, 0.14f, knot.nearest));
    }
    const float gap = Stroke(
        std::min(in_plank, 1 - in_plank) * plank_width, 0.0012f, s.footprint);
    return Mix(light, dark, std::clamp(t, 0.0f, 1.05f)) * (1 - 0.75f * gap);
  };
}

Texture Crate(Vector3f half_extents, uint32_t seed) {
  const Color light = FromSrgb(0xe0b878);
  const Color dark = FromSrgb(0x8a5a2c);
  const Texture slats = WoodPlanks(light, dark, 0.031f, seed);
  const Texture frame =
      WoodPlanks(light * 0.8f, dark * 0.8f, 10.0f, seed + 100);
  const Color ink = FromSrgb(0x3a2418);
  return [=](const SurfacePoint& s) -> Color {
    const int axis = s.face / 2;
    const Vector2f half =
        axis == 0   ? Vector2f(half_extents.y(), half_extents.z())
        : axis == 1 ? Vector2f(half_extents.x(), half_extents.z())
                    : Vector2f(half_extents.x(), half_extents.y());
    const Vector2f edge = half - s.uv.cwiseAbs();
    constexpr float kFrame = 0.019f;
    const float inset = std::min(edge.x(), edge.y());
    Color color = inset < kFrame ? frame(s) : slats(s);
    color *= 1 - 0.6f * Stroke(std::abs(inset - kFrame), 0.0012f, s.footprint);
    const Vector2f nail = edge - Vector2f(0.0095f, 0.0095f);
    if (nail.norm() < 0.0035f) color *= 0.25f;
    if (axis == 1) {
      const Vector2f start(-0.5f * half.x(), -0.012f);
      const float written =
          Letters((s.uv - start), 0.03f, 7, seed + s.face) *
          SmoothStep(
              -0.5f,
              0.1f,
              FractalNoise(s.position, 0.01f, 3, s.footprint, seed + 70));
      color = Mix(color, ink, 0.85f * written);
    }
    return color;
  };
}

Texture Bricks(uint32_t seed) {
  const Color mortar = FromSrgb(0xcfc6b4);
  const Color brick = FromSrgb(0xa8432c);
  const Color burnt = FromSrgb(0x5e2a24);
  return [=](const SurfacePoint& s) -> Color {
    constexpr float kWidth = 0.048f;
    constexpr float kHeight = 0.022f;
    const Vector2f uv = s.uv + Vector2f(0.011f, 0.007f);
    const float row = std::floor(uv.y() / kHeight);
    const float along =
        uv.x() / kWidth + 0.5f * static_cast<float>(static_cast<int>(row) & 1);
    const float column = std::floor(along);
    const Vector2f in((along - column) * kWidth, uv.y() - row * kHeight);
    const float edge = std::min(std::min(in.x(), kWidth - in.x()),
                                std::min(in.y(), kHeight - in.y()));
    const float rough =
        FractalNoise(s.position, 0.02f, 5, s.footprint, seed, 0.7f);
    const float tone = HashUnit(
        seed + s.face, static_cast<int>(column), static_cast<int>(row));
    Color color =
        Mix(brick,
            burnt,
            std::clamp(0.9f * tone * tone + 0.4f * rough, 0.0f, 1.0f));
    color *= 0.8f + 0.5f * tone + 0.25f * rough;
    const float joint = Stroke(edge + 0.0008f * rough, 0.0014f, s.footprint);
    return Mix(color, mortar * (0.85f + 0.3f * rough), joint);
  };
}

Texture Book(Vector3f half_extents, Color cover, Color accent, uint32_t seed) {
  const Color paper = FromSrgb(0xede4cc);
  const Color ink = FromSrgb(0x2a2620);
  return [=](const SurfacePoint& s) -> Color {
    const float wear = Wear(s, 0.22f, seed);
    const float rim = half_extents.z() - std::abs(s.position.z());
    const bool board = s.face >= 4 || s.face == 0 || rim < 0.003f;
    if (!board) {
      const float sheets = FractalNoise(
          {s.position.x() * 0.2f, s.position.y() * 0.2f, s.position.z()},
          0.004f,
          3,
          s.footprint,
          seed + 5,
          0.8f);
      return paper * (0.82f + 0.3f * sheets);
    }
    Color color = cover * wear;
    if (s.face < 4) return color;
    const Vector2f half(half_extents.x(), half_extents.y());
    const Vector2f edge = half - s.uv.cwiseAbs();
    const float inset = std::min(edge.x(), edge.y());
    color = Mix(
        color, accent, Stroke(std::abs(inset - 0.011f), 0.0018f, s.footprint));
    // A picture of overlapping discs in the middle, title above and below.
    const Vector2f p = s.uv;
    if (std::abs(p.x()) < half.x() - 0.022f && p.y() < 0.4f * half.y() &&
        p.y() > -0.62f * half.y()) {
      const CellHit cell = CellNoise(p.x() * 34, p.y() * 34, seed + 9);
      const float tone = static_cast<float>(cell.id & 255) / 255;
      const Color print = (cell.id & 256) != 0
                              ? Mix(accent, paper, tone)
                              : Mix(cover * 0.5f, accent, tone * 0.6f);
      color = Mix(ink, print, SmoothStep(0.03f, 0.09f, cell.border)) * wear;
    }
    const float title =
        Letters(p - Vector2f(-0.75f * half.x(), 0.5f * half.y()),
                0.021f,
                7,
                seed + 11) +
        Letters(p - Vector2f(-0.75f * half.x(), -0.82f * half.y()),
                0.012f,
                12,
                seed + 12);
    return Mix(color, paper, std::min(1.0f, title) * 0.95f);
  };
}

Texture StripedBall(Color first, Color second, int stripes, uint32_t seed) {
  const Color ink = FromSrgb(0x2c3038);
  return [=](const SurfacePoint& s) -> Color {
    const float turn = s.uv.x() / (2 * kPi) + 0.5f;
    const float phase = turn * 2 * static_cast<float>(stripes);
    const int stripe = static_cast<int>(std::floor(phase));
    Color color = (stripe & 1) != 0 ? first : second;
    const float cap = std::abs(s.uv.y());
    if (cap > 1.32f) color = first;
    // Prints: discs and rings scattered over the stripes.
    const Vector2f map(turn * 2 * static_cast<float>(stripes) * 1.5f,
                       s.uv.y() * 4.5f);
    const CellHit cell = CellNoise(map.x(), map.y(), seed);
    if (cap < 1.1f && cell.id % 3 != 0) {
      const float size = 0.16f + 0.0006f * static_cast<float>(cell.id % 250);
      const float d =
          cell.id % 2 == 0 ? cell.nearest : std::abs(cell.nearest - size);
      const float mark = 1 - SmoothStep(0.45f * size, 0.55f * size, d);
      color = Mix(color, (stripe & 1) != 0 ? second : ink, 0.9f * mark);
    }
    return color * Wear(s, 0.16f, seed + 3);
  };
}

Texture Blossoms(Color base, Color petals, Color heart, uint32_t seed) {
  return [=](const SurfacePoint& s) -> Color {
    const Vector2f map(s.uv.x() * 2.2f, s.uv.y() * 48);
    const CellHit cell = CellNoise(map.x(), map.y(), seed);
    Color color =
        base *
        (0.9f + 0.25f * FractalNoise(s.position, 0.02f, 4, s.footprint, seed));
    if (cell.id % 4 != 0) {
      const float angle = std::atan2(cell.offset_y, cell.offset_x);
      const float count = 3 + static_cast<float>(cell.id % 4);
      const float size = 0.22f + 0.001f * static_cast<float>(cell.id % 180);
      const float outline =
          size * (0.72f + 0.28f * std::cos(count * angle +
                                           static_cast<float>(cell.id % 7)));
      if (cell.nearest < outline) {
        color = Mix(petals, heart, SmoothStep(0.9f, 0.0f, cell.nearest / size));
      }
      if (cell.nearest < 0.3f * size) color = heart;
    } else if (cell.nearest < 0.13f) {
      color = petals;
    }
    return color * Wear(s, 0.1f, seed + 9);
  };
}

Texture Porcelain(Color glaze, uint32_t seed) {
  const Color white = FromSrgb(0xf2efe6);
  return [=](const SurfacePoint& s) -> Color {
    const float warp =
        FractalNoise(s.position, 0.05f, 4, s.footprint, seed + 1);
    const Vector2f map(s.uv.x() * 2.2f + 0.8f * warp,
                       s.position.z() * 34 + 0.8f * warp);
    const CellHit cell = CellNoise(map.x(), map.y(), seed);
    const float patch =
        cell.id % 5 < 2 ? SmoothStep(0.04f, 0.12f, cell.border) : 0.0f;
    const float vine =
        1 - SmoothStep(0.03f,
                       0.08f,
                       std::abs(FractalNoise(
                           s.position, 0.03f, 3, s.footprint, seed + 7)));
    const float dot =
        cell.id % 5 == 3 ? 1 - SmoothStep(0.1f, 0.16f, cell.nearest) : 0.0f;
    const float tone =
        0.7f +
        0.5f * FractalNoise(s.position, 0.012f, 4, s.footprint, seed + 4);
    const float ink = std::max({patch * tone, 0.65f * vine, dot});
    return Mix(white, glaze, std::clamp(ink, 0.0f, 1.0f)) *
           Wear(s, 0.1f, seed + 2);
  };
}

Texture Doughnut(Color icing, uint32_t seed) {
  const Color dough = FromSrgb(0xc88a48);
  const Color crust = FromSrgb(0x8a5222);
  const std::vector<Color> sprinkles = {FromSrgb(0xfff3d6),
                                        FromSrgb(0x35a7d8),
                                        FromSrgb(0xf7d23e),
                                        FromSrgb(0x5cb85c),
                                        FromSrgb(0xd84a3a),
                                        FromSrgb(0x6a4fb0)};
  return [=](const SurfacePoint& s) -> Color {
    const float edge =
        0.28f * std::sin(5 * s.uv.x() + 1) + 0.18f * std::sin(11 * s.uv.x()) +
        0.4f * FractalNoise(s.position, 0.02f, 3, s.footprint, seed);
    const float height = std::sin(s.uv.y());
    if (height < 0.12f * edge + 0.05f) {
      const float bake =
          FractalNoise(s.position, 0.015f, 5, s.footprint, seed + 2, 0.7f);
      return Mix(dough, crust, std::clamp(0.4f + 0.8f * bake, 0.0f, 1.0f));
    }
    Color color = icing * Wear(s, 0.14f, seed + 5);
    const CellHit cell = CellNoise(s.uv.x() * 7, s.uv.y() * 4.2f, seed + 7);
    const float angle = static_cast<float>(cell.id % 628) * 0.01f;
    const float along =
        cell.offset_x * std::cos(angle) + cell.offset_y * std::sin(angle);
    const float across =
        cell.offset_y * std::cos(angle) - cell.offset_x * std::sin(angle);
    const float d = std::hypot(std::max(0.0f, std::abs(along) - 0.2f), across);
    if (cell.id % 5 != 0 && d < 0.1f) {
      color = sprinkles[(cell.id >> 10) % sprinkles.size()];
    }
    return color;
  };
}

Texture BandedCone(Color base, Color band, float height, uint32_t seed) {
  const Color grime = FromSrgb(0x4a3a30);
  return [=](const SurfacePoint& s) -> Color {
    const float level = s.position.z() / height + 0.5f;
    Color color = base;
    if ((level > 0.32f && level < 0.5f) || (level > 0.66f && level < 0.78f)) {
      color = band;
    }
    const float radius = std::hypot(s.position.x(), s.position.y());
    const Vector2f run((s.uv.x() + 2.6f) * 0.045f, level * height);
    if (s.face == 0 && radius > 0.01f) {
      const float text =
          Letters(run - Vector2f(0.0f, 0.36f * height), 0.016f, 17, seed + 1) +
          Letters(run - Vector2f(0.0f, 0.12f * height), 0.012f, 20, seed + 2);
      color = Mix(color, grime, 0.85f * std::min(1.0f, text));
    }
    const float dirt =
        FractalNoise(s.position, 0.04f, 6, s.footprint, seed + 3, 0.7f);
    color = Mix(color, grime, std::clamp(0.75f * dirt - 0.08f, 0.0f, 0.7f));
    return color * Wear(s, 0.14f, seed + 8);
  };
}

Texture Checks(Color first, Color second, float size, uint32_t seed) {
  return [=](const SurfacePoint& s) -> Color {
    const Vector2f grid = s.uv / size + Vector2f(0.5f, 0.5f);
    const int ix = static_cast<int>(std::floor(grid.x()));
    const int iy = static_cast<int>(std::floor(grid.y()));
    const bool odd = ((ix + iy) & 1) != 0;
    Color color = odd ? first : second;
    const Color other = odd ? second : first;
    const Vector2f in = grid - Vector2f(static_cast<float>(ix) + 0.5f,
                                        static_cast<float>(iy) + 0.5f);
    const uint32_t id = HashCell(seed + s.face, ix, iy);
    bool ink = false;
    if (std::abs(in.x()) < 0.3f && std::abs(in.y()) < 0.36f) {
      const int x = static_cast<int>((in.x() + 0.3f) / 0.12f);
      const int y = static_cast<int>((in.y() + 0.36f) / 0.103f);
      ink = LetterBit(id, std::min(x, 4), std::min(y, 6));
    }
    if (ink) color = Mix(color, other, 0.9f);
    return color * Wear(s, 0.22f, seed + 6);
  };
}

Texture TinCan(Color label, Color print, float half_height, uint32_t seed) {
  const Color metal = FromSrgb(0xb9bcc0);
  const Color ink = FromSrgb(0x20242c);
  return [=](const SurfacePoint& s) -> Color {
    if (s.face != 0 || std::abs(s.position.z()) > 0.9f * half_height) {
      const float radius = std::hypot(s.position.x(), s.position.y());
      const float rings = 0.9f + 0.1f * std::sin(radius * 900);
      return metal * rings * Wear(s, 0.25f, seed);
    }
    const float level = s.position.z() / half_height;
    const Vector2f run((s.uv.x() + kPi) * 0.04f, s.position.z());
    Color color = label;
    if (level > 0.55f || level < -0.62f) color = print;
    const CellHit cell = CellNoise(s.uv.x() * 3.2f, level * 3.2f, seed + 2);
    if (level < 0.5f && level > -0.55f && cell.id % 3 == 0) {
      const float tone = static_cast<float>(cell.id & 127) / 127;
      color = Mix(color,
                  Mix(print, label * 0.4f, tone),
                  1 - SmoothStep(0.3f, 0.36f, cell.nearest));
    }
    const float text =
        Letters(
            run - Vector2f(0.01f, 0.1f * half_height), 0.024f, 11, seed + 3) +
        Letters(
            run - Vector2f(0.02f, -0.4f * half_height), 0.011f, 24, seed + 4);
    color = Mix(color, ink, 0.9f * std::min(1.0f, text));
    const float white = Letters(
        run - Vector2f(0.0f, 0.63f * half_height), 0.012f, 21, seed + 5);
    color = Mix(color, label, 0.9f * white);
    return color * Wear(s, 0.12f, seed + 6);
  };
}

Texture Marble(Color base, Color vein, uint32_t seed) {
  return [=](const SurfacePoint& s) -> Color {
    const float warp =
        FractalNoise(s.position, 0.08f, 6, s.footprint, seed, 0.6f);
    const float wave = std::abs(
        std::sin(70 * (s.position.x() + 0.6f * s.position.z() + 0.09f * warp)));
    const float fine =
        std::abs(FractalNoise(s.position, 0.03f, 5, s.footprint, seed + 9));
    const float t = std::max(1 - SmoothStep(0.0f, 0.35f, wave),
                             0.7f * (1 - SmoothStep(0.0f, 0.08f, fine)));
    const float cloud =
        0.9f +
        0.25f * FractalNoise(s.position, 0.03f, 5, s.footprint, seed + 3);
    return Mix(base * cloud, vein, std::clamp(t, 0.0f, 1.0f));
  };
}

}  // namespace freegs::scene_maker
