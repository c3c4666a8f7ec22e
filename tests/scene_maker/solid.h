// SPDX-License-Identifier: BSD-3-Clause
// The solids a scene is built of, with exact ray intersections and extents.

#ifndef FREEGS_TESTS_SCENE_MAKER_SOLID_H_
#define FREEGS_TESTS_SCENE_MAKER_SOLID_H_

#include <functional>
#include <limits>

#include <Eigen/Core>

namespace freegs::scene_maker {

// Linear-light colour.
using Color = Eigen::Vector3f;

// Where a ray met a surface, in the solid's own frame (metres).
struct SurfacePoint {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();
  Eigen::Vector3f normal =
      Eigen::Vector3f::UnitZ();  // Towards the ray's origin.

  // kBox: face 0..5 is -x +x -y +y -z +z, uv the in-plane coordinates with v up
  // (metres). kEllipsoid: uv = (longitude, latitude). kFrustum: face 0 is the
  // side with uv = (longitude, z), 1 the bottom and 2 the top with uv = (x, y).
  // kTorus: uv = (angle around the axis, angle around the tube). Radians.
  int face = 0;
  Eigen::Vector2f uv = Eigen::Vector2f::Zero();

  float footprint = 1e-3f;  // Size of a pixel on the surface (metres).
};

// The colour of a surface at a point.
using Texture = std::function<Color(const SurfacePoint&)>;

enum class Shape {
  kBox,        // size = half extents
  kEllipsoid,  // size = semi-axes
  kFrustum,    // along z: size = (bottom radius, top radius, half height)
  kTorus,      // around z: size = (major radius, minor radius, unused)
};

struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;  // Unit length.
};

struct Solid {
  Shape shape = Shape::kBox;
  Eigen::Vector3d size = Eigen::Vector3d::Ones();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // world_from_solid
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();        // World (metres).
  Texture texture;
  float gloss = 0;     // Strength of the highlight, 0..1.
  int object_id = 0;   // 1.. of an object, 0 for furniture and room.
  int background = 0;  // Index of the background class when object_id is 0.
  int surface = 0;     // Tells apart floor, table and walls; see scene_files.h.
};

struct Hit {
  double distance = 0;     // Along the ray, from its origin.
  Eigen::Vector3d normal;  // World frame, facing the ray's origin.
  SurfacePoint surface;    // Without the footprint.
};

// Distance along the ray of the first intersection as of Intersect, or kNoHit.
inline constexpr double kNoHit = std::numeric_limits<double>::infinity();
double Distance(const Solid& solid,
                const Ray& ray,
                double min_distance,
                double max_distance);

// The first intersection with min_distance < distance < max_distance. Surfaces
// are two-sided: a ray that starts inside a box sees its walls.
bool Intersect(const Solid& solid,
               const Ray& ray,
               double min_distance,
               double max_distance,
               Hit* hit);

// Largest dot product of `direction` (world) with a point of the solid.
double Support(const Solid& solid, const Eigen::Vector3d& direction);

// Radius of a sphere around `centre` that holds the solid.
double BoundingRadius(const Solid& solid);

// Volume in cubic metres and its centroid in the world.
double Volume(const Solid& solid);
Eigen::Vector3d Centroid(const Solid& solid);

}  // namespace freegs::scene_maker

#endif  // FREEGS_TESTS_SCENE_MAKER_SOLID_H_
