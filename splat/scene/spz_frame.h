// SPDX-License-Identifier: BSD-3-Clause
// The frames in which .spz files can be.

#ifndef FREEGS_SPLAT_SCENE_SPZ_FRAME_H_
#define FREEGS_SPLAT_SCENE_SPZ_FRAME_H_

#include <array>
#include <cstdint>
#include <string_view>

#include "core/status.h"

namespace freegs::splat {

// A frame of the extension SPZ_ADOBE_coordinate_system, 1 to 8: x is left or
// right, y down or up, z back or front, and the bits of the number less one say
// right, up and front.
inline constexpr uint32_t kRightUpBack = 4;     // If a file names no frame.
inline constexpr uint32_t kRightDownFront = 6;  // COLMAP's frame.

// What numbers of a model are multiplied by when axes turn round. The same
// signs lead there and back.
struct AxisSigns {
  std::array<double, 3> position = {};  // x y z
  std::array<double, 3> rotation = {};  // x y z of the quaternion; w stays.
  std::array<double, 15> sh = {};       // SH coefficients of degrees 1 to 3.
};

// The signs between two frames of 1 to 8.
AxisSigns SignsBetween(uint32_t a, uint32_t b);

// The frame that a file's extension records (the bytes after its arrays) name
// first, or kRightUpBack. Records of other types are skipped, and end where one
// is not whole. Fails with kBadInput for a frame in which y is neither up nor
// down, or that does not exist, and for a record of the frame that is damaged.
StatusOr<uint32_t> SpzFrame(std::string_view extensions);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_SCENE_SPZ_FRAME_H_
