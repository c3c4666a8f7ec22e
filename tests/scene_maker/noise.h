// SPDX-License-Identifier: BSD-3-Clause
// Pure functions of position that procedural textures are made of.

#ifndef FREEGS_TESTS_SCENE_MAKER_NOISE_H_
#define FREEGS_TESTS_SCENE_MAKER_NOISE_H_

#include <cstdint>

#include <Eigen/Core>

namespace freegs::scene_maker {

// 32 well-mixed bits of an integer lattice point.
inline uint32_t HashCell(uint32_t seed, int x, int y, int z = 0) {
  uint32_t h = seed * 0x9e3779b1u ^ static_cast<uint32_t>(x) * 0x8da6b343u ^
               static_cast<uint32_t>(y) * 0xd8163841u ^
               static_cast<uint32_t>(z) * 0xcb1ab31fu;
  h ^= h >> 16;
  h *= 0x7feb352du;
  h ^= h >> 15;
  h *= 0x846ca68bu;
  h ^= h >> 16;
  return h;
}

// Uniform in [0, 1) for a lattice point.
inline float HashUnit(uint32_t seed, int x, int y, int z = 0) {
  return static_cast<float>(HashCell(seed, x, y, z) >> 8) * 0x1p-24f;
}

// Gradient noise (Perlin 2002) with unit lattice cells, about [-1, 1].
float GradientNoise(const Eigen::Vector3f& point, uint32_t seed);

// Sum of `octaves` of gradient noise, each half the cell and `gain` times the
// amplitude of the one before; about [-1, 1]. The first has cells of size
// `cell`. Octaves whose cells are not clearly larger than `footprint` (the size
// of a pixel on the surface, same unit as point) fade out, so that distant
// surfaces do not alias.
float FractalNoise(const Eigen::Vector3f& point,
                   float cell,
                   int octaves,
                   float footprint,
                   uint32_t seed,
                   float gain = 0.55f);

// The nearest and second nearest of one random point per unit square.
struct CellHit {
  float nearest = 0;   // Distance to the nearest point.
  float border = 0;    // Second nearest minus nearest: 0 on cell borders.
  uint32_t id = 0;     // Random bits of the nearest point's cell.
  float offset_x = 0;  // From the nearest point.
  float offset_y = 0;
};
CellHit CellNoise(float x, float y, uint32_t seed);

// 0 below `low`, 1 above `high`, smooth between.
float SmoothStep(float low, float high, float x);

}  // namespace freegs::scene_maker

#endif  // FREEGS_TESTS_SCENE_MAKER_NOISE_H_
