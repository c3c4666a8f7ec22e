// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/metrics/box_iou.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>

namespace freegs::semantics {
namespace {

using Eigen::Vector3d;

// A face of a convex body: its corners in order, either way around.
using Polygon = std::vector<Vector3d>;

// The six faces, in units and axes of the box itself: corners at +-size / 2.
std::vector<Polygon> Faces(const Vector3d& half) {
  std::vector<Polygon> faces;
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    for (const double side : {-1.0, 1.0}) {
      Polygon face;
      for (const auto& [su, sv] : std::array<std::array<double, 2>, 4>{
               {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}}) {
        Vector3d corner;
        corner[axis] = side * half[axis];
        corner[u] = su * half[u];
        corner[v] = sv * half[v];
        face.push_back(corner);
      }
      faces.push_back(std::move(face));
    }
  }
  return faces;
}

// Orders points of a plane with the given normal around their mean.
Polygon SortedAround(Polygon points, const Vector3d& normal) {
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& point : points) mean += point;
  mean /= static_cast<double>(points.size());
  const Vector3d u = normal.unitOrthogonal();
  const Vector3d v = normal.cross(u);
  std::sort(
      points.begin(), points.end(), [&](const Vector3d& a, const Vector3d& b) {
        return std::atan2(v.dot(a - mean), u.dot(a - mean)) <
               std::atan2(v.dot(b - mean), u.dot(b - mean));
      });
  return points;
}

// Keeps the part of a convex body where normal . x <= offset (Sutherland and
// Hodgman 1974 on each face) and closes it with the cut. A body that touches
// the plane from inside already has a face or edge there and gets no new one.
std::vector<Polygon> Clip(const std::vector<Polygon>& faces,
                          const Vector3d& normal,
                          double offset,
                          double tolerance) {
  std::vector<Polygon> kept;
  Polygon cut;
  bool removed = false;
  for (const Polygon& face : faces) {
    Polygon part;
    for (size_t i = 0; i < face.size(); ++i) {
      const Vector3d& a = face[i];
      const Vector3d& b = face[(i + 1) % face.size()];
      const double da = normal.dot(a) - offset;
      const double db = normal.dot(b) - offset;
      removed = removed || da > tolerance;
      if (da <= tolerance) part.push_back(a);
      if (std::abs(da) <= tolerance) cut.push_back(a);
      if ((da < -tolerance && db > tolerance) ||
          (da > tolerance && db < -tolerance)) {
        const Vector3d crossing = a + (da / (da - db)) * (b - a);
        part.push_back(crossing);
        cut.push_back(crossing);
      }
    }
    if (part.size() >= 3) kept.push_back(std::move(part));
  }
  if (removed && cut.size() >= 3)
    kept.push_back(SortedAround(std::move(cut), normal));
  return kept;
}

// The sum of the cones from an inner point over the faces.
double ConvexVolume(const std::vector<Polygon>& faces) {
  Vector3d apex = Vector3d::Zero();
  size_t count = 0;
  for (const Polygon& face : faces) {
    for (const Vector3d& corner : face) apex += corner;
    count += face.size();
  }
  if (count == 0) return 0;
  apex /= static_cast<double>(count);
  double volume = 0;
  for (const Polygon& face : faces) {
    double six_times = 0;
    for (size_t i = 2; i < face.size(); ++i) {
      six_times += std::abs(
          (face[0] - apex).dot((face[i - 1] - apex).cross(face[i] - apex)));
    }
    volume += six_times / 6;
  }
  return volume;
}

double Ratio(double intersection, double volume_a, double volume_b) {
  const double all = volume_a + volume_b - intersection;
  return all > 0 ? std::clamp(intersection / all, 0.0, 1.0) : 0;
}

}  // namespace

double Volume(const AxisAlignedBox& box) {
  return (box.max - box.min).cwiseMax(0.0).prod();
}

double Volume(const OrientedBox& box) { return box.size.cwiseMax(0.0).prod(); }

double IntersectionVolume(const AxisAlignedBox& a, const AxisAlignedBox& b) {
  return (a.max.cwiseMin(b.max) - a.min.cwiseMax(b.min)).cwiseMax(0.0).prod();
}

double IntersectionVolume(const OrientedBox& a, const OrientedBox& b) {
  if (Volume(a) <= 0 || Volume(b) <= 0) return 0;
  // Work in a frame in which b is centred and has size 1, so that tolerances
  // are relative. The volume is scaled back by that of b.
  const Vector3d inverse_size = b.size.cwiseInverse();
  const Eigen::Matrix3d to_b =
      inverse_size.asDiagonal() * b.rotation.transpose();
  std::vector<Polygon> faces = Faces(0.5 * a.size);
  for (Polygon& face : faces) {
    for (Vector3d& corner : face) {
      corner = to_b * (a.rotation * corner + a.center - b.center);
    }
  }
  constexpr double kTolerance = 1e-12;
  for (int axis = 0; axis < 3 && !faces.empty(); ++axis) {
    for (const double side : {-1.0, 1.0}) {
      faces = Clip(faces, side * Vector3d::Unit(axis), 0.5, kTolerance);
    }
  }
  return std::min({ConvexVolume(faces) * Volume(b), Volume(a), Volume(b)});
}

double BoxIou(const AxisAlignedBox& a, const AxisAlignedBox& b) {
  return Ratio(IntersectionVolume(a, b), Volume(a), Volume(b));
}

double BoxIou(const OrientedBox& a, const OrientedBox& b) {
  return Ratio(IntersectionVolume(a, b), Volume(a), Volume(b));
}

}  // namespace freegs::semantics
