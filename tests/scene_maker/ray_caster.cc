// SPDX-License-Identifier: BSD-3-Clause

#include "tests/scene_maker/ray_caster.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "core/random.h"
#include "tests/scene_maker/textures.h"

namespace freegs::scene_maker {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kFar = 1e6;
constexpr double kSurfaceOffset = 1e-5;  // Metres; keeps rays off their origin.

// Samples of a pixel: a coarse grid, and a fine one where it sees contrast.
constexpr int kCoarse = 2;
constexpr int kFine = 3;
constexpr float kContrast = 0.12f;  // In square roots of linear light.

// What is tested per ray before the solid itself.
struct Bound {
  Vector3d centre;
  double radius2 = 0;    // Squared radius of the sphere around the solid.
  double occluder2 = 0;  // Squared radius of the ball of the same volume.
  bool casts_shadow = false;
};

bool MissesSphere(const Bound& bound, const Ray& ray) {
  const Vector3d to = bound.centre - ray.origin;
  const double along = to.dot(ray.direction);
  const double distance2 = to.squaredNorm();
  if (along < 0 && distance2 > bound.radius2) return true;
  return distance2 - along * along > bound.radius2;
}

class Caster {
 public:
  Caster(const Scene& scene, const View& view) : scene_(scene), view_(view) {
    for (const Solid& solid : scene.solids) {
      Bound bound;
      bound.centre = solid.centre;
      bound.radius2 = std::pow(BoundingRadius(solid) + 1e-9, 2);
      bound.occluder2 =
          std::pow(Volume(solid) * 3 / (4 * std::numbers::pi), 2.0 / 3.0);
      bound.casts_shadow =
          solid.object_id > 0 || solid.background == 0;  // Objects and table.
      bounds_.push_back(bound);
    }
    world_from_cam_ =
        view.cam_from_world.rotation.conjugate().toRotationMatrix();
    eye_ = CameraCentre(view.cam_from_world);
  }

  // The ray through a point of the image plane (pixels).
  Ray PixelRay(double x, double y) const {
    const Pinhole& camera = view_.camera;
    const Vector3d direction(
        (x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
    return {eye_, (world_from_cam_ * direction).normalized()};
  }

  // The index of the first solid hit, or -1.
  int Nearest(const Ray& ray, Hit* hit) const {
    int nearest = -1;
    double limit = kFar;
    for (size_t i = 0; i < bounds_.size(); ++i) {
      if (MissesSphere(bounds_[i], ray)) continue;
      const double distance =
          Distance(scene_.solids[i], ray, kSurfaceOffset, limit);
      if (distance < limit) {
        limit = distance;
        nearest = static_cast<int>(i);
      }
    }
    if (nearest >= 0) {
      Intersect(scene_.solids[static_cast<size_t>(nearest)],
                ray,
                kSurfaceOffset,
                kFar,
                hit);
    }
    return nearest;
  }

  // The light that a sample of the pixel gathers. (u, v) in [0, 1) picks the
  // point of the lamp it is lit from.
  Color Sample(const Ray& ray, double u, double v) const {
    Hit hit;
    const int index = Nearest(ray, &hit);
    if (index < 0) return Color(0, 0, 0);
    const Solid& solid = scene_.solids[static_cast<size_t>(index)];
    const Vector3d point = ray.origin + hit.distance * ray.direction;
    const double facing = std::max(0.2, -hit.normal.dot(ray.direction));
    hit.surface.footprint = static_cast<float>(
        0.75 * hit.distance / (view_.camera.fx * std::sqrt(facing)));
    const Color albedo = solid.texture(hit.surface).cwiseMax(0.0f);
    return Shade(solid, ray, point, hit.normal, albedo, u, v);
  }

 private:
  Color Shade(const Solid& solid,
              const Ray& ray,
              const Vector3d& point,
              const Vector3d& normal,
              const Color& albedo,
              double u,
              double v) const {
    // Light from everywhere: brighter and cooler from above, warm bounce from
    // below, less of it close to other objects.
    const float up = static_cast<float>(0.5 + 0.5 * normal.z());
    const Color sky(0.50f, 0.53f, 0.58f);
    const Color bounce(0.30f, 0.25f, 0.20f);
    const Color ambient =
        (bounce + up * (sky - bounce)) * Openness(solid, point, normal);

    // The lamp: a disc that faces the table, sampled at one point.
    const double radius = scene_.light_radius * std::sqrt(u);
    const double angle = 2 * std::numbers::pi * v;
    const Vector3d lamp =
        scene_.light + radius * Vector3d(std::cos(angle), std::sin(angle), 0);
    const Vector3d to_lamp = lamp - point;
    const double distance = to_lamp.norm();
    const Vector3d direction = to_lamp / distance;
    const double facing = normal.dot(direction);
    Color light = ambient;
    Color highlight(0, 0, 0);
    if (facing > 0 &&
        !Shadowed({point + kSurfaceOffset * normal, direction}, distance)) {
      const Color lamp_color(1.02f, 0.96f, 0.86f);
      const float falloff =
          static_cast<float>(5.2 / (1.2 + distance * distance));
      light += lamp_color * (falloff * static_cast<float>(facing));
      if (solid.gloss > 0) {
        const Vector3d half = (direction - ray.direction).normalized();
        highlight =
            lamp_color *
            (solid.gloss * static_cast<float>(std::pow(normal.dot(half), 60)));
      }
    }
    return albedo.cwiseProduct(light) + highlight;
  }

  bool Shadowed(const Ray& ray, double distance) const {
    for (size_t i = 0; i < bounds_.size(); ++i) {
      if (!bounds_[i].casts_shadow || MissesSphere(bounds_[i], ray)) continue;
      if (Distance(scene_.solids[i], ray, kSurfaceOffset, distance) != kNoHit) {
        return true;
      }
    }
    return false;
  }

  // The share of ambient light left by the other objects, each taken for the
  // ball of its volume: a ball of radius r at distance d in direction w takes
  // (n . w) r^2 / d^2 of the cosine-weighted half space.
  float Openness(const Solid& solid,
                 const Vector3d& point,
                 const Vector3d& normal) const {
    double open = 1;
    for (size_t i = 0; i < bounds_.size(); ++i) {
      const Solid& other = scene_.solids[i];
      if (other.object_id == 0 || other.object_id == solid.object_id) continue;
      const Vector3d to = bounds_[i].centre - point;
      const double along = normal.dot(to);
      if (along <= 0) continue;
      const double d2 = std::max(to.squaredNorm(), bounds_[i].occluder2);
      if (d2 > 200 * bounds_[i].occluder2) continue;  // Nothing to see.
      open *= 1 - 0.9 * along * bounds_[i].occluder2 / (d2 * std::sqrt(d2));
    }
    return static_cast<float>(open);
  }

  const Scene& scene_;
  const View& view_;
  std::vector<Bound> bounds_;
  Eigen::Matrix3d world_from_cam_;
  Vector3d eye_;
};

uint8_t Encode(float linear) {
  const float value = std::pow(std::clamp(linear, 0.0f, 1.0f), 1 / 2.2f);
  return static_cast<uint8_t>(std::lround(255 * value));
}

// Adds grid x grid samples of a pixel, jittered in their cells; returns their
// range of brightness.
float AddGrid(
    const Caster& caster, int x, int y, int grid, uint64_t stream, Color* sum) {
  float low = std::numeric_limits<float>::infinity();
  float high = 0;
  RandomStream random(stream, static_cast<uint64_t>(grid));
  const int count = grid * grid;
  // Every sample of the pixel gets its own slice of the lamp.
  const uint64_t turn = random.Index(static_cast<uint64_t>(count));
  for (int i = 0; i < count; ++i) {
    const double sx = x + (i % grid + random.Uniform()) / grid;
    const double sy = y + (i / grid + random.Uniform()) / grid;
    const int slice = static_cast<int>((static_cast<uint64_t>(i) * 7 + turn) %
                                       static_cast<uint64_t>(count));
    const double u = random.Uniform();
    const double v = (slice + random.Uniform()) / count;
    const Color color =
        caster.Sample(caster.PixelRay(sx, sy), u, v).cwiseMin(1.2f);
    *sum += color;
    const float bright = std::sqrt(color.sum() / 3);
    low = std::min(low, bright);
    high = std::max(high, bright);
  }
  return high - low;
}

}  // namespace

Photo CastRays(const Scene& scene, const View& view, ThreadPool& pool) {
  const int width = view.camera.width;
  const int height = view.camera.height;
  Photo photo{ImageU8(width, height, 3),
              ImageU16(width, height, 1),
              ImageU16(width, height, 1),
              ImageF(width, height, 1)};
  const Caster caster(scene, view);
  const Vector3d forward =
      view.cam_from_world.rotation.conjugate() * Vector3d::UnitZ();
  pool.ParallelFor(0, height, 4, [&](int64_t first, int64_t last, int) {
    for (int y = static_cast<int>(first); y < last; ++y) {
      for (int x = 0; x < width; ++x) {
        const Ray ray = caster.PixelRay(x + 0.5, y + 0.5);
        Hit hit;
        const int index = caster.Nearest(ray, &hit);
        if (index >= 0) {
          const Solid& solid = scene.solids[static_cast<size_t>(index)];
          photo.instances(x, y) = static_cast<uint16_t>(solid.object_id);
          photo.background(x, y) = static_cast<uint16_t>(
              solid.object_id > 0 ? 0 : solid.background + 1);
          photo.depth(x, y) =
              static_cast<float>(hit.distance * forward.dot(ray.direction));
        }
        const uint64_t stream =
            MixBits(scene.options.seed ^ (static_cast<uint64_t>(y) << 32 ^
                                          static_cast<uint64_t>(x)));
        Color sum(0, 0, 0);
        int count = kCoarse * kCoarse;
        if (AddGrid(caster, x, y, kCoarse, stream, &sum) > kContrast) {
          AddGrid(caster, x, y, kFine, stream, &sum);
          count += kFine * kFine;
        }
        for (int c = 0; c < 3; ++c) {
          photo.color(x, y, c) = Encode(sum[c] / static_cast<float>(count));
        }
      }
    }
  });
  return photo;
}

}  // namespace freegs::scene_maker
