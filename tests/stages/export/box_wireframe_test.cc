// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/box_wireframe.h"

#include <set>
#include <sstream>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

TEST(BoxWireframeTest, BarsLieOnTheEdges) {
  ColoredBox colored;
  colored.box.centre = {1, 2, 3};
  colored.box.size = {2, 4, 6};
  colored.box.rotation =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())
          .toRotationMatrix();
  colored.color = {10, 20, 30};
  const ColoredBox boxes[] = {colored, colored};
  std::istringstream ply(SerializeBoxWireframes(boxes));
  std::string word;
  size_t num_vertices = 0;
  size_t num_faces = 0;
  while (ply >> word && word != "end_header") {
    if (word == "vertex") ply >> num_vertices;
    if (word == "face") ply >> num_faces;
  }
  ASSERT_EQ(num_vertices, 2u * 12 * 8);
  ASSERT_EQ(num_faces, 2u * 12 * 12);
  std::vector<Eigen::Vector3d> vertices(num_vertices);
  const double half_width = 0.002 * colored.box.size.norm();
  for (Eigen::Vector3d& vertex : vertices) {
    int r = 0;
    int g = 0;
    int b = 0;
    ply >> vertex.x() >> vertex.y() >> vertex.z() >> r >> g >> b;
    EXPECT_EQ(r, 10);
    EXPECT_EQ(b, 30);
    // All eight corners of a bar are near a corner of the box.
    const Eigen::Vector3d local =
        colored.box.rotation.transpose() * (vertex - colored.box.centre);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(
          std::abs(local[k]), colored.box.size[k] / 2, half_width + 1e-5);
    }
  }
  // A closed, outward facing surface: its volume is that of 24 bars.
  double volume = 0;
  for (size_t f = 0; f < num_faces; ++f) {
    int count = 0;
    std::array<size_t, 3> v{};
    ply >> count >> v[0] >> v[1] >> v[2];
    ASSERT_EQ(count, 3);
    for (const size_t index : v) ASSERT_LT(index, num_vertices);
    volume += vertices[v[0]].dot(vertices[v[1]].cross(vertices[v[2]])) / 6;
  }
  ASSERT_FALSE(ply.fail());
  const double width = 2 * half_width;
  const double expected = 2 * 4 * width * width * (2 + 4 + 6 + 3 * width);
  EXPECT_NEAR(volume, expected, 0.01 * expected);
  EXPECT_FALSE(ply >> word);
}

TEST(BoxWireframeTest, NoBoxIsAnEmptyMesh) {
  const std::string ply = SerializeBoxWireframes({});
  EXPECT_NE(ply.find("element vertex 0\n"), std::string::npos);
  EXPECT_TRUE(ply.ends_with("end_header\n"));
}

}  // namespace
}  // namespace freegs::stages
