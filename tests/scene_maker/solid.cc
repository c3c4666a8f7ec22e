// SPDX-License-Identifier: BSD-3-Clause

#include "tests/scene_maker/solid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace freegs::scene_maker {
namespace {

using Eigen::Vector3d;

// Open interval of distances in which a hit counts.
struct Range {
  double min = 0;
  double max = 0;
  bool Has(double t) const { return t > min && t < max; }
};

// A hit in the solid's frame, where rays keep their length unit.
struct LocalHit {
  double t = 0;
  Vector3d position;
  Vector3d normal;
  int face = 0;
};

bool IntersectBox(const Vector3d& half,
                  const Vector3d& o,
                  const Vector3d& d,
                  const Range& range,
                  LocalHit* hit) {
  double near = -1e30;
  double far = 1e30;
  int near_axis = 0;
  int far_axis = 0;
  for (int axis = 0; axis < 3; ++axis) {
    // A zero component divides to infinities of the right signs, except for an
    // origin exactly on a face; the nudge keeps NaN out.
    const double inverse = 1.0 / (std::abs(d[axis]) > 1e-15 ? d[axis] : 1e-15);
    double a = (-half[axis] - o[axis]) * inverse;
    double b = (half[axis] - o[axis]) * inverse;
    if (a > b) std::swap(a, b);
    if (a > near) {
      near = a;
      near_axis = axis;
    }
    if (b < far) {
      far = b;
      far_axis = axis;
    }
  }
  if (near > far) return false;
  const bool outside = range.Has(near);
  if (!outside && !range.Has(far)) return false;
  hit->t = outside ? near : far;
  const int axis = outside ? near_axis : far_axis;
  hit->position = o + hit->t * d;
  hit->face = 2 * axis + (hit->position[axis] > 0 ? 1 : 0);
  hit->normal = Vector3d::Zero();
  hit->normal[axis] = hit->position[axis] > 0 ? 1 : -1;
  return true;
}

bool IntersectEllipsoid(const Vector3d& axes,
                        const Vector3d& o,
                        const Vector3d& d,
                        const Range& range,
                        LocalHit* hit) {
  const Vector3d po = o.cwiseQuotient(axes);
  const Vector3d pd = d.cwiseQuotient(axes);
  const double a = pd.squaredNorm();
  const double b = po.dot(pd);
  const double c = po.squaredNorm() - 1;
  const double discriminant = b * b - a * c;
  if (discriminant <= 0) return false;
  const double root = std::sqrt(discriminant);
  double t = (-b - root) / a;
  if (!range.Has(t)) t = (-b + root) / a;
  if (!range.Has(t)) return false;
  hit->t = t;
  hit->position = o + t * d;
  hit->normal =
      hit->position.cwiseQuotient(axes.cwiseProduct(axes)).normalized();
  hit->face = 0;
  return true;
}

bool IntersectFrustum(const Vector3d& size,
                      const Vector3d& o,
                      const Vector3d& d,
                      const Range& range,
                      LocalHit* hit) {
  const double half = size.z();
  const double slope = (size.y() - size.x()) / (2 * half);  // dr/dz
  const double middle = 0.5 * (size.x() + size.y());        // r at z = 0
  Range left = range;
  bool found = false;
  const auto keep = [&](double t, const Vector3d& normal, int face) {
    left.max = t;
    hit->t = t;
    hit->position = o + t * d;
    hit->normal = normal;
    hit->face = face;
    found = true;
  };
  // Side: x^2 + y^2 = (middle + slope z)^2.
  const double radius = middle + slope * o.z();
  const double a =
      d.x() * d.x() + d.y() * d.y() - slope * slope * d.z() * d.z();
  const double b = o.x() * d.x() + o.y() * d.y() - slope * d.z() * radius;
  const double c = o.x() * o.x() + o.y() * o.y() - radius * radius;
  const double discriminant = b * b - a * c;
  if (discriminant > 0 && std::abs(a) > 1e-15) {
    const double root = std::sqrt(discriminant);
    for (const double t : {(-b - root) / a, (-b + root) / a}) {
      const double z = o.z() + t * d.z();
      if (!left.Has(t) || std::abs(z) > half) continue;
      const Vector3d p = o + t * d;
      const double r = middle + slope * z;
      keep(t, Vector3d(p.x(), p.y(), -slope * r).normalized(), 0);
    }
  }
  for (const int face : {1, 2}) {
    if (d.z() == 0) break;
    const double sign = face == 1 ? -1 : 1;
    const double t = (sign * half - o.z()) / d.z();
    const Vector3d p = o + t * d;
    const double r = face == 1 ? size.x() : size.y();
    if (left.Has(t) && p.x() * p.x() + p.y() * p.y() <= r * r) {
      keep(t, Vector3d(0, 0, sign), face);
    }
  }
  return found;
}

// Steps along the ray by the distance to the torus (Hart 1996), which is exact
// outside it; rays that start inside are not needed.
bool IntersectTorus(const Vector3d& size,
                    const Vector3d& o,
                    const Vector3d& d,
                    const Range& range,
                    LocalHit* hit) {
  const double reach = size.x() + size.y();
  const double b = o.dot(d);
  const double discriminant = b * b - o.squaredNorm() + reach * reach;
  if (discriminant <= 0) return false;
  double t = std::max(range.min, -b - std::sqrt(discriminant));
  const double end = std::min(range.max, -b + std::sqrt(discriminant));
  constexpr double kTolerance = 1e-7;
  for (int step = 0; step < 256 && t < end; ++step) {
    const Vector3d p = o + t * d;
    const double ring = std::sqrt(p.x() * p.x() + p.y() * p.y());
    const double across = ring - size.x();
    const double distance =
        std::sqrt(across * across + p.z() * p.z()) - size.y();
    if (distance < kTolerance) {
      if (!range.Has(t)) return false;
      const double scale = ring > 0 ? across / ring : 0;
      hit->t = t;
      hit->position = p;
      hit->normal = Vector3d(p.x() * scale, p.y() * scale, p.z()).normalized();
      hit->face = 0;
      return true;
    }
    t += distance;
  }
  return false;
}

Eigen::Vector2d SurfaceUv(const Solid& solid, const LocalHit& hit) {
  const Vector3d& p = hit.position;
  switch (solid.shape) {
    case Shape::kBox:
      if (hit.face < 2) return {hit.face == 0 ? -p.y() : p.y(), p.z()};
      if (hit.face < 4) return {hit.face == 2 ? p.x() : -p.x(), p.z()};
      return {p.x(), p.y()};
    case Shape::kEllipsoid: {
      const Vector3d q = p.cwiseQuotient(solid.size);
      return {std::atan2(q.y(), q.x()), std::asin(std::clamp(q.z(), -1., 1.))};
    }
    case Shape::kFrustum:
      if (hit.face == 0) return {std::atan2(p.y(), p.x()), p.z()};
      return {p.x(), p.y()};
    case Shape::kTorus:
      return {std::atan2(p.y(), p.x()),
              std::atan2(p.z(), std::hypot(p.x(), p.y()) - solid.size.x())};
  }
  return {0, 0};
}

Ray ToLocal(const Solid& solid, const Ray& ray) {
  return {solid.rotation.transpose() * (ray.origin - solid.centre),
          solid.rotation.transpose() * ray.direction};
}

bool IntersectLocal(const Solid& solid,
                    const Ray& ray,
                    const Range& range,
                    LocalHit* hit) {
  switch (solid.shape) {
    case Shape::kBox:
      return IntersectBox(solid.size, ray.origin, ray.direction, range, hit);
    case Shape::kEllipsoid:
      return IntersectEllipsoid(
          solid.size, ray.origin, ray.direction, range, hit);
    case Shape::kFrustum:
      return IntersectFrustum(
          solid.size, ray.origin, ray.direction, range, hit);
    case Shape::kTorus:
      return IntersectTorus(solid.size, ray.origin, ray.direction, range, hit);
  }
  return false;
}

}  // namespace

double Distance(const Solid& solid,
                const Ray& ray,
                double min_distance,
                double max_distance) {
  LocalHit hit;
  return IntersectLocal(
             solid, ToLocal(solid, ray), {min_distance, max_distance}, &hit)
             ? hit.t
             : kNoHit;
}

bool Intersect(const Solid& solid,
               const Ray& ray,
               double min_distance,
               double max_distance,
               Hit* hit) {
  const Ray own = ToLocal(solid, ray);
  LocalHit local;
  if (!IntersectLocal(solid, own, {min_distance, max_distance}, &local)) {
    return false;
  }
  if (local.normal.dot(own.direction) > 0) local.normal = -local.normal;
  hit->distance = local.t;
  hit->normal = solid.rotation * local.normal;
  hit->surface.position = local.position.cast<float>();
  hit->surface.normal = local.normal.cast<float>();
  hit->surface.face = local.face;
  hit->surface.uv = SurfaceUv(solid, local).cast<float>();
  return true;
}

double Support(const Solid& solid, const Vector3d& direction) {
  const Vector3d d = solid.rotation.transpose() * direction;
  const double planar = std::hypot(d.x(), d.y());
  double local = 0;
  switch (solid.shape) {
    case Shape::kBox:
      local = solid.size.dot(d.cwiseAbs());
      break;
    case Shape::kEllipsoid:
      local = solid.size.cwiseProduct(d).norm();
      break;
    case Shape::kFrustum:
      local = std::max(planar * solid.size.x() - solid.size.z() * d.z(),
                       planar * solid.size.y() + solid.size.z() * d.z());
      break;
    case Shape::kTorus:
      local = planar * solid.size.x() + d.norm() * solid.size.y();
      break;
  }
  return direction.dot(solid.centre) + local;
}

double BoundingRadius(const Solid& solid) {
  switch (solid.shape) {
    case Shape::kBox:
      return solid.size.norm();
    case Shape::kEllipsoid:
      return solid.size.maxCoeff();
    case Shape::kFrustum:
      return std::hypot(std::max(solid.size.x(), solid.size.y()),
                        solid.size.z());
    case Shape::kTorus:
      return solid.size.x() + solid.size.y();
  }
  return 0;
}

double Volume(const Solid& solid) {
  constexpr double kPi = std::numbers::pi;
  const Vector3d& s = solid.size;
  switch (solid.shape) {
    case Shape::kBox:
      return 8 * s.prod();
    case Shape::kEllipsoid:
      return 4.0 / 3.0 * kPi * s.prod();
    case Shape::kFrustum:
      return kPi / 3 * 2 * s.z() *
             (s.x() * s.x() + s.x() * s.y() + s.y() * s.y());
    case Shape::kTorus:
      return 2 * kPi * kPi * s.x() * s.y() * s.y();
  }
  return 0;
}

Vector3d Centroid(const Solid& solid) {
  if (solid.shape != Shape::kFrustum) return solid.centre;
  const double a = solid.size.x();
  const double b = solid.size.y();
  const double height = 2 * solid.size.z();
  const double above_bottom =
      height * (a * a + 2 * a * b + 3 * b * b) / (4 * (a * a + a * b + b * b));
  return solid.centre + solid.rotation.col(2) * (above_bottom - solid.size.z());
}

}  // namespace freegs::scene_maker
