// SPDX-License-Identifier: BSD-3-Clause
// Where the photographer stands.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <Eigen/Geometry>

#include "core/random.h"
#include "tests/scene_maker/clutter.h"
#include "tests/scene_maker/scene.h"

namespace freegs::scene_maker {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;
constexpr uint64_t kClutterStream = 9000;
constexpr double kLargestStep = 9 * kDegree;

// More photos than this go around the table more than once, because photos that
// are closer together show next to no parallax.
constexpr int kPhotosOfATurn = 300;

int Turns(const SceneMakerOptions& options) {
  return (options.views + kPhotosOfATurn - 1) / kPhotosOfATurn;
}

// A camera at `eye` that sees `target` in its middle, upright.
Rigid3d LookAt(const Vector3d& eye, const Vector3d& target) {
  const Vector3d z = (target - eye).normalized();
  const Vector3d x = z.cross(Vector3d::UnitZ()).normalized();
  const Vector3d y = z.cross(x);
  Eigen::Matrix3d rotation;
  rotation.row(0) = x;
  rotation.row(1) = y;
  rotation.row(2) = z;
  Rigid3d pose;
  pose.rotation = Eigen::Quaterniond(rotation).normalized();
  pose.translation = -(pose.rotation * eye);
  return pose;
}

// Around one chair after the other, from the side that looks past it at the
// other one.
Rigid3d PoseAtChairs(const SceneMakerOptions& options,
                     double index,
                     RandomStream* shake) {
  const auto around = [shake](double half_range) {
    return half_range * (2 * shake->Uniform() - 1);
  };
  constexpr double kArc = 200 * kDegree;
  const int first = (options.views + 1) / 2;
  const bool second = index > first - 0.5;
  const int count = second ? options.views - first : first;
  const double share = count < 2 ? 0.5
                                 : (second ? index - first : index) /
                                       static_cast<double>(count - 1);
  const double azimuth =
      (second ? 0 : std::numbers::pi) + (share - 0.5) * kArc + around(0.02);
  const double elevation =
      (30 + 6 * std::sin(9 * share) + around(1.5)) * kDegree;
  const double aside = around(0.02);
  const Vector3d target(kChairs[second ? 1 : 0].x + around(0.02), aside, 0.45);
  const double distance = 1.4 + around(0.05);
  return LookAt(
      target + distance * Vector3d(std::cos(elevation) * std::cos(azimuth),
                                   std::cos(elevation) * std::sin(azimuth),
                                   std::sin(elevation)),
      target);
}

// Along the wall at y = 2.5, of which the lowest 1.2 metres and a strip of the
// floor are in the picture.
Rigid3d PoseAtWall(const SceneMakerOptions& options,
                   double index,
                   RandomStream* shake) {
  const auto around = [shake](double half_range) {
    return half_range * (2 * shake->Uniform() - 1);
  };
  const double share = options.views < 2 ? 0.5 : index / (options.views - 1);
  const double nearer = around(0.1);
  const Vector3d eye(-1.9 + 3.8 * share + around(0.03),
                     0.9 + nearer,
                     1.2 + 0.15 * std::sin(9 * share));
  return LookAt(eye, {eye.x() + 0.3 * std::sin(7 * share), 2.5, 0.52});
}

// From all over a half sphere around the board, as NeRF-synthetic has it.
// Every further photo is higher up and a golden angle (Vogel 1979) farther
// around, which spreads them evenly.
Rigid3d PoseOnHalfSphere(const SceneMakerOptions& options, double index) {
  constexpr double kGoldenAngle = 2.399963229728653;  // pi * (3 - sqrt(5)).
  constexpr double kDistance = 1.5;
  // Sine of the elevation, never straight up.
  const double up = (index + 1) / (options.views + 1);
  const double flat = std::sqrt(1 - up * up);
  const double azimuth = index * kGoldenAngle;
  const Vector3d target(0, 0, kTableHeight + 0.05);
  return LookAt(target + kDistance * Vector3d(flat * std::cos(azimuth),
                                              flat * std::sin(azimuth),
                                              up),
                target);
}

// Number `index` of a path whose photos are `step` apart; fractions are between
// photos. `stream` decides how the hand shakes.
Rigid3d PoseOnPath(const SceneMakerOptions& options,
                   double index,
                   double step,
                   uint64_t stream) {
  RandomStream shake(options.seed, stream);
  const auto around = [&shake](double half_range) {
    return half_range * (2 * shake.Uniform() - 1);
  };
  const double azimuth = -70 * kDegree + (index + around(0.12)) * step;
  if (options.motion == Motion::kRotation) {
    const Vector3d eye(0.3, -1.35, 1.45);
    const double tilt = (-14 + 9 * std::sin(2.7 * azimuth)) * kDegree;
    const double heading = azimuth + 160 * kDegree;
    return LookAt(eye,
                  eye + Vector3d(std::cos(tilt) * std::cos(heading),
                                 std::cos(tilt) * std::sin(heading),
                                 std::sin(tilt)));
  }
  if (options.subject == Subject::kChairs) {
    return PoseAtChairs(options, index, &shake);
  }
  if (options.subject == Subject::kTiles) {
    return PoseAtWall(options, index, &shake);
  }
  if (options.subject == Subject::kStudio) {
    return PoseOnHalfSphere(options, index);
  }
  // Up and down three times on the way around, so that neighbours stay close
  // and every side is seen from several heights. A second turn is at other
  // heights than the first.
  const double waves = Turns(options) > 1 ? 3.25 : 3;
  const double elevation =
      (31 + 13 * std::sin(waves * azimuth + 0.6) + around(1.5)) * kDegree;
  double distance = 1.32 + 0.08 * std::sin(2 * azimuth) + around(0.03);
  Vector3d target(0, around(0.02), kTableHeight + 0.05);
  target.x() = around(0.02);
  if (options.subject == Subject::kClutter) {
    // Every scene is seen from another distance, and not always in the middle.
    RandomStream choice(options.seed, kClutterStream);
    const double scale = ClutterScale(options.seed);
    distance *= scale * (0.45 + 0.65 * choice.Uniform());
    target.x() += scale * (0.3 * choice.Uniform() - 0.15);
    target.y() += scale * (0.3 * choice.Uniform() - 0.15);
  }
  if (options.subject == Subject::kFurniture) {
    distance *= 1.5;
    target.z() = 0.4;
  }
  const Vector3d eye =
      target + distance * Vector3d(std::cos(elevation) * std::cos(azimuth),
                                   std::cos(elevation) * std::sin(azimuth),
                                   std::sin(elevation));
  return LookAt(eye, target);
}

}  // namespace

void AddViews(Scene* scene) {
  const SceneMakerOptions& options = scene->options;
  Pinhole camera;
  camera.width = options.width;
  camera.height = options.height;
  camera.fx = camera.fy =
      0.5 * options.width / std::tan(0.5 * options.field_of_view * kDegree);
  camera.cx = 0.5 * options.width;
  camera.cy = 0.5 * options.height;
  const double step =
      options.arc > 0
          ? options.arc * kDegree / options.views
          : std::min(kLargestStep,
                     2 * std::numbers::pi * Turns(options) / options.views);
  char name[32];
  for (int i = 0; i < options.views; ++i) {
    std::snprintf(name, sizeof(name), "frame_%04d.jpg", i + 1);
    scene->train.push_back(
        {name, camera, PoseOnPath(options, i, step, static_cast<uint64_t>(i))});
  }
  for (int i = 0; i < options.test_views; ++i) {
    std::snprintf(name, sizeof(name), "test_%02d.png", i + 1);
    // Half way between two photos; the shake takes it off the path.
    const double index =
        std::floor((i + 0.5) * (options.views - 1) / options.test_views) + 0.5;
    scene->test.push_back(
        {name,
         camera,
         PoseOnPath(options, index, step, 100000 + static_cast<uint64_t>(i))});
  }
}

}  // namespace freegs::scene_maker
