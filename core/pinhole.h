// SPDX-License-Identifier: BSD-3-Clause
// A camera without lens distortion, as the splat renderer needs it, and which
// focal lengths a camera can have.

#ifndef FREEGS_CORE_PINHOLE_H_
#define FREEGS_CORE_PINHOLE_H_

#include <algorithm>
#include <cmath>
#include <string>

#include "core/rigid3d.h"

namespace freegs {

// The least and the largest focal length, in multiples of the longest side of
// the image. No photograph has a field of view above 150 degrees or below a
// fifth of one.
inline constexpr double kMinFocalRatio = 0.13;
inline constexpr double kMaxFocalRatio = 300;

// Pinhole intrinsics in pixels. A point (x, y, z) of the camera frame (x right,
// y down, z forward) falls on (fx x/z + cx, fy y/z + cy), where the centre of
// the top-left pixel is (0.5, 0.5).
struct Pinhole {
  int width = 0;
  int height = 0;
  double fx = 0;
  double fy = 0;
  double cx = 0;
  double cy = 0;

  // This camera with its image resized to new_width x new_height.
  Pinhole Resized(int new_width, int new_height) const {
    const double sx = static_cast<double>(new_width) / width;
    const double sy = static_cast<double>(new_height) / height;
    return {new_width, new_height, fx * sx, fy * sy, cx * sx, cy * sy};
  }

  // This camera with the longest side reduced to max_side pixels if it is
  // longer. max_side <= 0 sets no limit.
  Pinhole LimitedTo(int max_side) const {
    const int side = std::max(width, height);
    if (max_side <= 0 || side <= max_side) return *this;
    const double scale = static_cast<double>(max_side) / side;
    return Resized(std::max(1, static_cast<int>(std::lround(width * scale))),
                   std::max(1, static_cast<int>(std::lround(height * scale))));
  }
};

// A named, posed pinhole camera.
struct View {
  std::string name;  // Photo name relative to the image folder.
  Pinhole camera;
  Rigid3d cam_from_world;
};

}  // namespace freegs

#endif  // FREEGS_CORE_PINHOLE_H_
