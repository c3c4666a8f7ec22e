// SPDX-License-Identifier: BSD-3-Clause
// Boxes as a mesh that any PLY viewer shows: twelve thin bars each.

#ifndef FREEGS_STAGES_EXPORT_BOX_WIREFRAME_H_
#define FREEGS_STAGES_EXPORT_BOX_WIREFRAME_H_

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "semantics/geometry/boxes.h"

namespace freegs::stages {

struct ColoredBox {
  semantics::OrientedBox box;
  std::array<uint8_t, 3> color = {0, 0, 0};  // RGB.
};

// An ascii PLY with coloured vertices and triangles, world units. A bar along
// each of the twelve edges, centred on it, 0.4 % of the box's diagonal wide:
// lines of one pixel ("edge" elements) are shown by few programs.
std::string SerializeBoxWireframes(std::span<const ColoredBox> boxes);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EXPORT_BOX_WIREFRAME_H_
