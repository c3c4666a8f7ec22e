// SPDX-License-Identifier: BSD-3-Clause
// How much free space two objects of a scene have between them.

#ifndef FREEGS_TESTS_SCENE_MAKER_FREE_SPACE_H_
#define FREEGS_TESTS_SCENE_MAKER_FREE_SPACE_H_

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Core>

#include "tests/scene_maker/scene.h"
#include "tests/scene_maker/solid.h"

namespace freegs::scene_maker {

// The width in metres of the widest straight gap between the objects a and b as
// seen from above; negative if no straight line parts them. Only directions of
// whole degrees are tried, so there may be one that is a little wider.
inline double FreeSpace(const Scene& scene, int a, int b) {
  constexpr int kDirections = 360;
  constexpr double kNone = std::numeric_limits<double>::infinity();
  double widest = -kNone;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2 * std::numbers::pi * i / kDirections;
    const Eigen::Vector3d direction(std::cos(angle), std::sin(angle), 0);
    double end_of_a = -kNone;
    double begin_of_b = kNone;
    for (const Solid& solid : scene.solids) {
      if (solid.object_id == a) {
        end_of_a = std::max(end_of_a, Support(solid, direction));
      } else if (solid.object_id == b) {
        begin_of_b = std::min(begin_of_b, -Support(solid, -direction));
      }
    }
    widest = std::max(widest, begin_of_b - end_of_a);
  }
  return widest;
}

}  // namespace freegs::scene_maker

#endif  // FREEGS_TESTS_SCENE_MAKER_FREE_SPACE_H_
