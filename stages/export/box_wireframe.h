// SPDX-License-Identifier: BSD-3-Clause
// Draws boxes as a mesh of thin bars, which any PLY viewer shows.

#ifndef FREEGS_STAGES_EXPORT_BOX_WIREFRAME_H_
#define FREEGS_STAGES_EXPORT_BOX_WIREFRAME_H_

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include <Eigen/Core>

#include "semantics/geometry/boxes.h"

namespace freegs::stages {

struct ColoredBox {
  semantics::OrientedBox box;
  std::array<uint8_t, 3> color = {0, 0, 0};  // RGB.
};

// Returns an ascii PLY of coloured vertices and triangles in world units. Each
// box is twelve bars, centred on its edges and 0.4 % of its diagonal wide. Bars
// are used because few programs show the "edge" elements of a PLY. Positions
// count from `offset`, as in splat::WritePly.
std::string SerializeBoxWireframes(
    std::span<const ColoredBox> boxes,
    const Eigen::Vector3d& offset = Eigen::Vector3d::Zero());

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EXPORT_BOX_WIREFRAME_H_
