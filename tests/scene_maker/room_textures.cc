// SPDX-License-Identifier: BSD-3-Clause
// The surfaces of the room: floor and walls.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/scene_maker/noise.h"
#include "tests/scene_maker/textures.h"

namespace freegs::scene_maker {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float kRoomPi = std::numbers::pi_v<float>;

Color MixShades(const Color& a, const Color& b, float t) {
  return a + t * (b - a);
}

// A colour for a random number: warm and cool hues of equal weight.
Color PaletteColor(uint32_t id) {
  constexpr uint32_t kPalette[] = {0xb5452f,
                                   0x2f5d8a,
                                   0xe0b04a,
                                   0x3f7d5a,
                                   0x6b3f63,
                                   0xd98c5f,
                                   0x274056,
                                   0xcfc3a1,
                                   0x8c2f39,
                                   0x5f8f9f,
                                   0xe6dcc3,
                                   0x4a4e3a};
  return FromSrgb(kPalette[id % 12]);
}

// An abstract painting of warped cells over a horizon.
Color Painting(Vector2f p, const SurfacePoint& s, uint32_t seed) {
  const float warp = FractalNoise(s.position, 0.3f, 4, s.footprint, seed + 3);
  const CellHit cell = CellNoise(p.x() * 6 + warp, p.y() * 6 - warp, seed);
  const CellHit fine = CellNoise(p.x() * 19 + warp, p.y() * 19, seed + 1);
  Color color = PaletteColor(cell.id >> 3);
  if (fine.id % 3 == 0)
    color = MixShades(color, PaletteColor(fine.id >> 4), 0.7f);
  color *=
      0.85f + 0.35f * FractalNoise(s.position, 0.05f, 4, s.footprint, seed + 2);
  return MixShades(
      FromSrgb(0x1d1d22), color, SmoothStep(0.02f, 0.06f, cell.border));
}

}  // namespace

Texture FloorWithRug(float rug_radius, uint32_t seed) {
  const Texture boards =
      WoodPlanks(FromSrgb(0xa9845c), FromSrgb(0x4c3422), 0.14f, seed);
  const Color red = FromSrgb(0x8f2f2c);
  const Color cream = FromSrgb(0xe3d3b0);
  const Color blue = FromSrgb(0x27476b);
  return [=](const SurfacePoint& s) -> Color {
    const Vector2f p = s.position.head<2>();
    const float radius = p.norm();
    if (radius > rug_radius) {
      SurfacePoint far = s;
      far.position *= 0.6f;
      far.footprint *= 0.6f;
      const float shadow = SmoothStep(0.0f, 0.05f, radius - rug_radius);
      return boards(far) * (0.6f + 0.4f * shadow);
    }
    const float level = radius / rug_radius * 9;
    const int ring = static_cast<int>(level);
    const int petals = 5 + 4 * ring;
    const float turn = (std::atan2(p.y(), p.x()) / (2 * kRoomPi) + 0.5f) *
                       static_cast<float>(petals);
    const int petal = static_cast<int>(turn);
    const Vector2f in(turn - static_cast<float>(petal) - 0.5f,
                      level - static_cast<float>(ring) - 0.5f);
    const uint32_t id = HashCell(seed + 4, ring, petal);
    Color color = ring % 3 == 0 ? red : ring % 3 == 1 ? blue : cream;
    const Color motif = ring % 3 == 2 ? PaletteColor(id) : cream;
    const float shape =
        (id & 1) != 0 ? std::abs(in.x()) + std::abs(in.y()) : in.norm();
    const float size = 0.22f + 0.2f * HashUnit(seed + 5, ring, petal);
    if (shape < size) color = motif;
    if (shape < 0.45f * size) color = PaletteColor(id >> 5);
    if (std::abs(in.y()) > 0.44f) color = cream * 0.8f;
    const float pile =
        FractalNoise(s.position, 0.06f, 5, s.footprint, seed + 6, 0.75f);
    return color * std::max(0.2f, 0.85f + 0.45f * pile);
  };
}

Texture PictureWall(Color paint,
                    float half_width,
                    float half_height,
                    uint32_t seed) {
  const Texture wainscot =
      WoodPlanks(FromSrgb(0x7fa093), FromSrgb(0x3d5f58), 0.12f, seed + 50);
  const Color frame = FromSrgb(0x3b2a1e);
  const Color mat = FromSrgb(0xf0ead8);
  return [=](const SurfacePoint& s) -> Color {
    const Vector2f p = s.uv;
    if (p.y() < -half_height + 0.55f) {
      // Boards upright: swap the axes the planks run along.
      SurfacePoint board = s;
      board.position = Vector3f(p.y() * 0.5f, p.x(), 0);
      board.normal = Vector3f::UnitZ();
      const float rail = std::abs(p.y() + half_height - 0.52f);
      return wainscot(board) * (rail < 0.012f ? 0.55f : 0.95f);
    }
    const float plaster =
        FractalNoise(s.position, 0.5f, 8, s.footprint, seed, 0.68f);
    const CellHit blotch = CellNoise(p.x() * 7, p.y() * 7, seed + 2);
    Color color = paint * (0.92f + 0.28f * plaster);
    // Wallpaper: a sprig in every cell, turned and sized at random.
    const float angle = std::atan2(blotch.offset_y, blotch.offset_x) +
                        static_cast<float>(blotch.id % 63) * 0.1f;
    const float leaves = 3 + static_cast<float>(blotch.id % 3);
    const float size = 0.2f + 0.0009f * static_cast<float>(blotch.id % 200);
    if (blotch.nearest < size * (0.55f + 0.45f * std::cos(leaves * angle))) {
      color = MixShades(color, PaletteColor(blotch.id >> 4), 0.55f);
    }
    // Three pictures side by side.
    const float slot = 2 * half_width / 3;
    const int index = std::clamp(
        static_cast<int>(std::floor((p.x() + half_width) / slot)), 0, 2);
    const float centre_x = -half_width +
                           (static_cast<float>(index) + 0.5f) * slot +
                           0.15f * (HashUnit(seed, index, 5) - 0.5f);
    const float centre_y = -0.12f + 0.2f * (HashUnit(seed, index, 6) - 0.5f);
    const Vector2f half(0.3f + 0.2f * HashUnit(seed, index, 7),
                        0.28f + 0.16f * HashUnit(seed, index, 8));
    const Vector2f in = p - Vector2f(centre_x, centre_y);
    const Vector2f edge = half - in.cwiseAbs();
    const float inset = std::min(edge.x(), edge.y());
    if (inset > 0) {
      if (inset < 0.035f) {
        const float grain =
            FractalNoise(s.position, 0.05f, 4, s.footprint, seed + 12);
        return frame * (1 + 0.6f * grain) * (inset < 0.008f ? 1.8f : 1.0f);
      }
      if (inset < 0.065f) return mat;
      return Painting(in, s, seed + 20 + static_cast<uint32_t>(index));
    }
    if (inset > -0.03f && in.y() < half.y()) color *= 0.8f;  // Its shadow.
    return color;
  };
}

Texture BookShelves(float half_width, float half_height, uint32_t seed) {
  const Texture wood =
      WoodPlanks(FromSrgb(0x9a6b3f), FromSrgb(0x4a2e1a), 0.2f, seed);
  return [=](const SurfacePoint& s) -> Color {
    constexpr float kShelf = 0.36f;
    const float height = s.uv.y() + half_height;
    const int shelf = static_cast<int>(std::floor(height / kShelf));
    const float above = height - static_cast<float>(shelf) * kShelf;
    const float along = s.uv.x() + half_width;
    const float bay = along / 0.95f - std::floor(along / 0.95f);
    if (above < 0.028f || bay < 0.03f) {
      SurfacePoint board = s;
      board.position = Vector3f(s.uv.x() * 0.5f, s.uv.y(), 0);
      board.normal = Vector3f::UnitZ();
      return wood(board);
    }
    // Spines of varied width: each cell of 9 cm holds two or three books.
    constexpr float kCell = 0.09f;
    const int cell = static_cast<int>(std::floor(along / kCell));
    float in = along / kCell - static_cast<float>(cell);
    const uint32_t id = HashCell(seed, cell, shelf);
    const float cut_a = 0.25f + 0.2f * HashUnit(seed + 1, cell, shelf);
    const float cut_b = 0.6f + 0.2f * HashUnit(seed + 2, cell, shelf);
    const int slot = in < cut_a ? 0 : in < cut_b ? 1 : 2;
    const float left = slot == 0 ? 0 : slot == 1 ? cut_a : cut_b;
    const float right = slot == 0 ? cut_a : slot == 1 ? cut_b : 1;
    const uint32_t book = HashCell(id, slot, 3);
    const float tall = 0.2f + 0.1f * HashUnit(seed + 3, cell * 3 + slot, shelf);
    const Color gloom = FromSrgb(0x2a1c12);
    if (above - 0.028f > tall || book % 17 == 0) {
      const float grain =
          FractalNoise(s.position, 0.1f, 5, s.footprint, seed + 7);
      return gloom * (1 + 0.5f * grain);
    }
    const float across = (in - left) / (right - left);
    const float level = (above - 0.028f) / tall;
    Color color = PaletteColor(book);
    const Color gold = FromSrgb(0xe2c071);
    const Color other = PaletteColor(book >> 5);
    const int style = static_cast<int>((book >> 9) % 4);
    if (style == 0 &&
        (std::abs(level - 0.15f) < 0.02f || std::abs(level - 0.85f) < 0.02f)) {
      color = gold;
    }
    if (style == 1 && level > 0.55f && level < 0.8f) color = other;
    if (style == 2 && level > 0.3f && level < 0.42f) color = gold;
    if (across > 0.25f && across < 0.75f && level > 0.2f && level < 0.75f) {
      const int x = static_cast<int>((across - 0.25f) * 10);
      const int y = static_cast<int>((level - 0.2f) * 46);
      if (y % 4 != 3 &&
          LetterBit(book + static_cast<uint32_t>(y / 4), x, y % 4)) {
        color = MixShades(color, style == 1 ? FromSrgb(0x1c1a18) : gold, 0.8f);
      }
    }
    // Round spines catch the light in the middle.
    const float round =
        0.35f + 0.75f * std::sqrt(std::max(0.0f, 4 * across * (1 - across)));
    const float worn =
        1 + 0.4f * FractalNoise(s.position, 0.06f, 5, s.footprint, seed + 8);
    return color * round * std::max(0.3f, worn);
  };
}

Texture Tiles(float size, uint32_t seed) {
  const Color glaze = FromSrgb(0xe9e4d6);
  const Color grout = FromSrgb(0x8d887e);
  return [=](const SurfacePoint& s) -> Color {
    const Vector2f grid = s.uv / size;
    const Vector2f in(grid.x() - std::floor(grid.x()) - 0.5f,
                      grid.y() - std::floor(grid.y()) - 0.5f);
    SurfacePoint own = s;  // The noise below repeats from tile to tile, too.
    own.position = Vector3f(in.x() * size, in.y() * size, 0);
    const float edge = (0.5f - in.cwiseAbs().maxCoeff()) * size;
    if (edge < 0.004f) return grout;
    const CellHit cell = CellNoise(in.x() * 5, in.y() * 5, seed);
    const float blot =
        FractalNoise(own.position, 0.08f, 5, s.footprint, seed + 1);
    Color color = glaze * (0.9f + 0.25f * blot);
    if (cell.id % 3 != 0) {
      color = MixShades(color,
                        PaletteColor(cell.id >> 4),
                        SmoothStep(0.03f, 0.1f, cell.border));
    }
    return color;
  };
}

}  // namespace freegs::scene_maker
