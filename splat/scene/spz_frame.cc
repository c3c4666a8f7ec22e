// SPDX-License-Identifier: BSD-3-Clause

#include "splat/scene/spz_frame.h"

#include <cstddef>
#include <string>

#include "core/io/byte_stream.h"

namespace freegs::splat {
namespace {

constexpr uint32_t kFrameRecord = 0xADBE0003;
constexpr uint32_t kUnspecifiedFrame = 0;
constexpr uint32_t kLastFrame = 8;

// The axes in which the polynomial of each SH coefficient is odd.
constexpr std::array<std::string_view, 15> kOddAxes = {"y",
                                                       "z",
                                                       "x",
                                                       "xy",
                                                       "yz",
                                                       "",
                                                       "xz",
                                                       "",
                                                       "y",
                                                       "xyz",
                                                       "y",
                                                       "z",
                                                       "x",
                                                       "z",
                                                       "x"};

// A rotation about an axis leads from one of the two other axes to the other,
// so it changes its sign with each of them.
constexpr std::array<std::string_view, 3> kAxesOfRotation = {"yz", "xz", "xy"};
constexpr std::array<std::string_view, 3> kAxesOfPosition = {"x", "y", "z"};

}  // namespace

AxisSigns SignsBetween(uint32_t a, uint32_t b) {
  const uint32_t turned = (a - 1) ^ (b - 1);
  const auto sign = [turned](std::string_view axes) {
    double product = 1;
    for (const char axis : axes) {
      if ((turned >> (axis - 'x') & 1) != 0) product = -product;
    }
    return product;
  };
  AxisSigns signs;
  for (size_t k = 0; k < 3; ++k) {
    signs.position[k] = sign(kAxesOfPosition[k]);
    signs.rotation[k] = sign(kAxesOfRotation[k]);
  }
  for (size_t k = 0; k < kOddAxes.size(); ++k) signs.sh[k] = sign(kOddAxes[k]);
  return signs;
}

StatusOr<uint32_t> SpzFrame(std::string_view extensions) {
  // Each record is a type, the number of bytes that follow, and these bytes.
  uint32_t type = 0;
  uint32_t length = 0;
  for (;;) {
    ByteReader reader(extensions);
    if (!reader.Get(&type) || !reader.Get(&length)) return kRightUpBack;
    const bool whole = length <= reader.remaining();
    if (type == kFrameRecord) {
      uint32_t frame = 0;
      if (!whole || length < sizeof(frame) || !reader.Get(&frame)) {
        return BadInputError("the record of the coordinate system is damaged");
      }
      if (frame == kUnspecifiedFrame) return kRightUpBack;
      if (frame <= kLastFrame) return frame;
      return BadInputError("coordinate system " + std::to_string(frame) +
                           " (SPZ_ADOBE_coordinate_system) is not supported; 1 "
                           "to 8 are, in which y is up or down");
    }
    if (!whole) return kRightUpBack;
    extensions.remove_prefix(sizeof(type) + sizeof(length) + length);
  }
}

}  // namespace freegs::splat
