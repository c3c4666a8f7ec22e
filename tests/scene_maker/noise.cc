// SPDX-License-Identifier: BSD-3-Clause

#include "tests/scene_maker/noise.h"

#include <algorithm>
#include <cmath>

namespace freegs::scene_maker {
namespace {

float Fade(float t) { return t * t * t * (t * (t * 6 - 15) + 10); }
float Lerp(float a, float b, float t) { return a + t * (b - a); }

// The directions to the edges of a cube; four of them twice, to make 16.
constexpr float kGradients[16][3] = {{1, 1, 0},
                                     {-1, 1, 0},
                                     {1, -1, 0},
                                     {-1, -1, 0},
                                     {1, 0, 1},
                                     {-1, 0, 1},
                                     {1, 0, -1},
                                     {-1, 0, -1},
                                     {0, 1, 1},
                                     {0, -1, 1},
                                     {0, 1, -1},
                                     {0, -1, -1},
                                     {1, 1, 0},
                                     {-1, 1, 0},
                                     {0, -1, 1},
                                     {0, -1, -1}};

// std::floor is a library call on the baseline instruction set.
int Floor(float x) {
  const int truncated = static_cast<int>(x);
  return truncated - (static_cast<float>(truncated) > x ? 1 : 0);
}

}  // namespace

float GradientNoise(const Eigen::Vector3f& point, uint32_t seed) {
  const int cell[3] = {Floor(point.x()), Floor(point.y()), Floor(point.z())};
  const float x = point.x() - static_cast<float>(cell[0]);
  const float y = point.y() - static_cast<float>(cell[1]);
  const float z = point.z() - static_cast<float>(cell[2]);
  // As HashCell, with one round less: this is where the time goes.
  const uint32_t hx = static_cast<uint32_t>(cell[0]) * 0x8da6b343u;
  const uint32_t hy = static_cast<uint32_t>(cell[1]) * 0xd8163841u;
  const uint32_t hz =
      static_cast<uint32_t>(cell[2]) * 0xcb1ab31fu ^ seed * 0x9e3779b1u;
  float corner[8];
  for (int i = 0; i < 8; ++i) {
    uint32_t h = (hx + ((i & 1) != 0 ? 0x8da6b343u : 0u)) ^
                 (hy + ((i & 2) != 0 ? 0xd8163841u : 0u)) ^
                 (hz + ((i & 4) != 0 ? 0xcb1ab31fu : 0u));
    h = (h ^ h >> 15) * 0x7feb352du;
    h = (h ^ h >> 13) * 0x846ca68bu;
    const float* gradient = kGradients[h >> 28];
    corner[i] = gradient[0] * (x - static_cast<float>(i & 1)) +
                gradient[1] * (y - static_cast<float>(i >> 1 & 1)) +
                gradient[2] * (z - static_cast<float>(i >> 2));
  }
  const float u = Fade(x);
  const float v = Fade(y);
  return Lerp(
      Lerp(Lerp(corner[0], corner[1], u), Lerp(corner[2], corner[3], u), v),
      Lerp(Lerp(corner[4], corner[5], u), Lerp(corner[6], corner[7], u), v),
      Fade(z));
}

float FractalNoise(const Eigen::Vector3f& point,
                   float cell,
                   int octaves,
                   float footprint,
                   uint32_t seed,
                   float gain) {
  float sum = 0;
  float amplitude = 1;
  for (int octave = 0; octave < octaves; ++octave) {
    const float fade = SmoothStep(0.8f, 2.5f, cell / footprint);
    if (fade <= 0) break;
    sum += fade * amplitude * GradientNoise(point / cell, seed + octave);
    cell *= 0.5f;
    amplitude *= gain;
  }
  return sum;
}

CellHit CellNoise(float x, float y, uint32_t seed) {
  const int ix = Floor(x);
  const int iy = Floor(y);
  CellHit hit;
  float best = 1e9f;
  float second = 1e9f;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const uint32_t id = HashCell(seed, ix + dx, iy + dy);
      const float px = static_cast<float>(ix + dx) +
                       static_cast<float>(id & 0xffff) * 0x1p-16f;
      const float py =
          static_cast<float>(iy + dy) + static_cast<float>(id >> 16) * 0x1p-16f;
      const float d = (x - px) * (x - px) + (y - py) * (y - py);
      if (d < best) {
        second = best;
        best = d;
        hit.id = HashCell(id, 1, 2);
        hit.offset_x = x - px;
        hit.offset_y = y - py;
      } else {
        second = std::min(second, d);
      }
    }
  }
  hit.nearest = std::sqrt(best);
  hit.border = std::sqrt(second) - hit.nearest;
  return hit;
}

float SmoothStep(float low, float high, float x) {
  const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

}  // namespace freegs::scene_maker
