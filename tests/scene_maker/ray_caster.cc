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

// The balls around solids, in arrays that the compiler can walk with SIMD: most
// rays miss most solids, and this is how they find out.
class Bounds {
 public:
  void Add(const Solid& solid, int index) {
    x_.push_back(static_cast<float>(solid.centre.x()));
    y_.push_back(static_cast<float>(solid.centre.y()));
    z_.push_back(static_cast<float>(solid.centre.z()));
    const double radius = BoundingRadius(solid);
    radius2_.push_back(static_cast<float>(radius * radius) + kMargin);
    index_.push_back(index);
  }

  // Calls visit(index) for every solid whose ball the ray may meet, in the
  // order added, until visit returns false.
  template <typename Visit>
  void ForEachNear(const Ray& ray, const Visit& visit) const {
    const float ox = static_cast<float>(ray.origin.x());
    const float oy = static_cast<float>(ray.origin.y());
    const float oz = static_cast<float>(ray.origin.z());
    const float dx = static_cast<float>(ray.direction.x());
    const float dy = static_cast<float>(ray.direction.y());
    const float dz = static_cast<float>(ray.direction.z());
    float excess[kBlock];
    for (size_t first = 0; first < x_.size(); first += kBlock) {
      const size_t count = std::min(kBlock, x_.size() - first);
      for (size_t k = 0; k < count; ++k) {
        const float cx = x_[first + k] - ox;
        const float cy = y_[first + k] - oy;
        const float cz = z_[first + k] - oz;
        const float along = cx * dx + cy * dy + cz * dz;
        const float ahead = 0.5f * (along + std::abs(along));  // Branchless.
        excess[k] =
            cx * cx + cy * cy + cz * cz - ahead * ahead - radius2_[first + k];
      }
      for (size_t k = 0; k < count; ++k) {
        if (excess[k] <= 0 && !visit(index_[first + k])) return;
      }
    }
  }

 private:
  static constexpr size_t kBlock = 32;

  // Square metres: above the rounding error of the test.
  static constexpr float kMargin = 5e-5f;

  std::vector<float> x_, y_, z_, radius2_;
  std::vector<int> index_;
};

// An object as the ball of its volume, for ambient light.
struct Occluder {
  Vector3f centre;
  float radius2 = 0;
  int object_id = 0;
};

class Caster {
 public:
  Caster(const Scene& scene, const View& view) : scene_(scene), view_(view) {
    for (size_t i = 0; i < scene.solids.size(); ++i) {
      const Solid& solid = scene.solids[i];
      all_.Add(solid, static_cast<int>(i));
      if (solid.object_id > 0 || solid.background == 0) {
        shadows_.Add(solid, static_cast<int>(i));  // Objects and table.
      }
      if (solid.object_id > 0) {
        const double radius3 = Volume(solid) * 3 / (4 * std::numbers::pi);
        occluders_.push_back({solid.centre.cast<float>(),
                              static_cast<float>(std::pow(radius3, 2.0 / 3.0)),
                              solid.object_id});
      }
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
    all_.ForEachNear(ray, [&](int index) {
      const double distance =
          Distance(scene_.solids[static_cast<size_t>(index)],
                   ray,
                   kSurfaceOffset,
                   limit);
      if (distance < limit) {
        limit = distance;
        nearest = index;
      }
      return true;
    });
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
    if (index < 0) {
      return scene_.options.subject == Subject::kStudio ? Color(1, 1, 1)
                                                        : Color(0, 0, 0);
    }
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
        (bounce + up * (sky - bounce)) *
        Openness(solid.object_id, point.cast<float>(), normal.cast<float>());

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
    bool shadowed = false;
    shadows_.ForEachNear(ray, [&](int index) {
      shadowed = Distance(scene_.solids[static_cast<size_t>(index)],
                          ray,
                          kSurfaceOffset,
                          distance) != kNoHit;
      return !shadowed;
    });
    return shadowed;
  }

  // The share of ambient light left by the other objects, each taken for the
  // ball of its volume: a ball of radius r at distance d in direction w takes
  // (n . w) r^2 / d^2 of the cosine-weighted half space.
  float Openness(int object_id,
                 const Vector3f& point,
                 const Vector3f& normal) const {
    float open = 1;
    for (const Occluder& occluder : occluders_) {
      const Vector3f to = occluder.centre - point;
      const float along = normal.dot(to);
      const float distance2 = std::max(to.squaredNorm(), occluder.radius2);
      // Behind the surface, itself, or too small to be seen.
      if (along <= 0 || occluder.object_id == object_id ||
          distance2 > 200 * occluder.radius2) {
        continue;
      }
      open *= 1 - 0.9f * along * occluder.radius2 /
                      (distance2 * std::sqrt(distance2));
    }
    return open;
  }

  const Scene& scene_;
  const View& view_;
  Bounds all_;
  Bounds shadows_;
  std::vector<Occluder> occluders_;
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
          photo.surfaces(x, y) = static_cast<uint16_t>(
              solid.object_id > 0 ? solid.object_id
                                  : kFirstSurface + solid.surface);
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
