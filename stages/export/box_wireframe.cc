// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/box_wireframe.h"

#include <cstddef>
#include <cstdio>

#include <Eigen/Core>

#include "splat/scene/ply_io.h"

namespace freegs::stages {
namespace {

constexpr double kBarWidth = 0.004;  // Share of the box's diagonal.
constexpr int kNumBars = 12;
constexpr int kCornersPerBar = 8;

// The two triangles of each side of a cuboid whose corner k has the sign bits x
// = k & 1, y = k & 2, z = k & 4; counter-clockwise seen from outside.
constexpr int kTriangles[12][3] = {{0, 2, 3},
                                   {0, 3, 1},
                                   {4, 5, 7},
                                   {4, 7, 6},
                                   {0, 1, 5},
                                   {0, 5, 4},
                                   {2, 6, 7},
                                   {2, 7, 3},
                                   {0, 4, 6},
                                   {0, 6, 2},
                                   {1, 3, 7},
                                   {1, 7, 5}};

double Sign(int corner, int axis) { return (corner >> axis & 1) != 0 ? 1 : -1; }

void AppendVertex(const Eigen::Vector3d& point,
                  const std::array<uint8_t, 3>& color,
                  std::string* ply) {
  char line[128];
  std::snprintf(line,
                sizeof(line),
                "%.9g %.9g %.9g %d %d %d\n",
                point.x(),
                point.y(),
                point.z(),
                color[0],
                color[1],
                color[2]);
  *ply += line;
}

void AppendBars(const ColoredBox& colored,
                const Eigen::Vector3d& offset,
                std::string* ply) {
  const semantics::OrientedBox& box = colored.box;
  const double half_width = 0.5 * kBarWidth * box.size.norm();
  for (int bar = 0; bar < kNumBars; ++bar) {
    // The bar runs along `axis`, at one of four places of the other two.
    const int axis = bar / 4;
    const int axis1 = (axis + 1) % 3;
    const int axis2 = (axis + 2) % 3;
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    center[axis1] = 0.5 * Sign(bar, 0) * box.size[axis1];
    center[axis2] = 0.5 * Sign(bar, 1) * box.size[axis2];
    Eigen::Vector3d half = Eigen::Vector3d::Constant(half_width);
    half[axis] += 0.5 * box.size[axis];
    for (int corner = 0; corner < kCornersPerBar; ++corner) {
      Eigen::Vector3d local = center;
      for (int k = 0; k < 3; ++k) local[k] += Sign(corner, k) * half[k];
      AppendVertex(
          box.centre - offset + box.rotation * local, colored.color, ply);
    }
  }
}

}  // namespace

std::string SerializeBoxWireframes(std::span<const ColoredBox> boxes,
                                   const Eigen::Vector3d& offset) {
  const size_t num_bars = kNumBars * boxes.size();
  std::string ply =
      "ply\nformat ascii 1.0\n" + splat::PlyOffsetLine(offset) +
      "element vertex " + std::to_string(kCornersPerBar * num_bars) +
      "\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\n"
      "element face " +
      std::to_string(std::size(kTriangles) * num_bars) +
      "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const ColoredBox& box : boxes) AppendBars(box, offset, &ply);
  for (size_t bar = 0; bar < num_bars; ++bar) {
    for (const auto& triangle : kTriangles) {
      ply += "3";
      for (const int corner : triangle) {
        ply += " " + std::to_string(kCornersPerBar * bar +
                                    static_cast<size_t>(corner));
      }
      ply += "\n";
    }
  }
  return ply;
}

}  // namespace freegs::stages
