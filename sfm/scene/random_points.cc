// SPDX-License-Identifier: BSD-3-Clause
// Random start points.

#include "sfm/scene/random_points.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "core/quantile.h"
#include "core/random.h"

namespace freegs::sfm {
namespace {

constexpr uint64_t kBallStream = 0x62616c6c;
constexpr uint64_t kRayStream = 0x726179;
constexpr int kAttempts = 64;

bool IsSeen(const Reconstruction& model,
            const std::vector<const Camera*>& cameras,
            const Eigen::Vector3d& point) {
  for (size_t i = 0; i < model.images.size(); ++i) {
    const auto pixel =
        Project(*cameras[i], model.images[i].cam_from_world * point);
    if (pixel && pixel->x() >= 0 && pixel->y() >= 0 &&
        pixel->x() < static_cast<double>(cameras[i]->width) &&
        pixel->y() < static_cast<double>(cameras[i]->height)) {
      return true;
    }
  }
  return false;
}

Eigen::Vector3d InBall(const SceneFocus& focus,
                       uint64_t seed,
                       uint64_t counter) {
  Eigen::Vector3d direction(RandomNormal(seed, kBallStream, 4 * counter),
                            RandomNormal(seed, kBallStream, 4 * counter + 1),
                            RandomNormal(seed, kBallStream, 4 * counter + 2));
  const double norm = direction.norm();
  if (norm > 0) direction /= norm;
  const double radius = std::cbrt(RandomUniform(seed, ~kBallStream, counter)) *
                        focus.distance / 2;
  return focus.centre + radius * direction;
}

// Lens distortion is left out: the pixel only has to be a random one.
Eigen::Vector3d OnRay(const Reconstruction& model,
                      const std::vector<const Camera*>& cameras,
                      const SceneFocus& focus,
                      uint64_t seed,
                      uint64_t counter) {
  const auto uniform = [&](uint64_t k) {
    return RandomUniform(seed, kRayStream, 4 * counter + k);
  };
  const size_t i = static_cast<size_t>(uniform(0) * model.images.size());
  const Camera& camera = *cameras[i];
  const double inverse_depth =
      (0.25 + uniform(1) * (4 - 0.25)) / focus.distance;
  const double z = 1 / inverse_depth;
  const Eigen::Vector3d in_camera(
      (uniform(2) * camera.width - camera.PrincipalX()) / camera.FocalX() * z,
      (uniform(3) * camera.height - camera.PrincipalY()) / camera.FocalY() * z,
      z);
  return Inverse(model.images[i].cam_from_world) * in_camera;
}

}  // namespace

SceneFocus EstimateFocus(const Reconstruction& model) {
  SceneFocus focus;
  const double n = static_cast<double>(model.images.size());
  if (model.images.empty()) return focus;
  std::vector<Eigen::Vector3d> centres;
  Eigen::Vector3d mean_centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_axis = Eigen::Vector3d::Zero();
  for (const PosedImage& image : model.images) {
    centres.push_back(CameraCentre(image.cam_from_world));
    mean_centre += centres.back() / n;
    mean_axis += image.cam_from_world.rotation.conjugate() *
                 Eigen::Vector3d::UnitZ() / n;
  }
  // From here on relative to the mean centre, which may be far away.
  double extent = 0;
  for (Eigen::Vector3d& centre : centres) {
    centre -= mean_centre;
    extent = std::max(extent, centre.norm());
  }
  // Sum of the projections across each axis, plus a weak pull towards a place
  // in front of the cameras.
  constexpr double kPull = 1e-3;
  Eigen::Matrix3d a = kPull * n * Eigen::Matrix3d::Identity();
  Eigen::Vector3d b = kPull * n * extent * mean_axis;
  for (size_t i = 0; i < centres.size(); ++i) {
    const Eigen::Vector3d axis =
        model.images[i].cam_from_world.rotation.conjugate() *
        Eigen::Vector3d::UnitZ();
    const Eigen::Matrix3d across =
        Eigen::Matrix3d::Identity() - axis * axis.transpose();
    a += across;
    b += across * centres[i];
  }
  const Eigen::Vector3d centre = a.ldlt().solve(b);
  std::vector<double> distances;
  for (const Eigen::Vector3d& camera : centres) {
    distances.push_back((camera - centre).norm());
  }
  focus.centre = mean_centre + centre;
  const double distance = UpperMedian(std::move(distances));
  // Cameras in one place know no length. Rounding moves them apart by about
  // 1e-16 of their distance from the origin.
  const bool one_place = extent <= 1e-12 * mean_centre.norm();
  focus.distance = !one_place && distance > 1e-9 * extent ? distance : 1;
  return focus;
}

StatusOr<std::vector<Point3D>> RandomPoints(const Reconstruction& model,
                                            int count,
                                            uint64_t seed) {
  FREEGS_RETURN_IF_ERROR(CheckReconstruction(model));
  if (model.images.empty()) {
    return BadInputError("no camera to place random points in front of");
  }
  const SceneFocus focus = EstimateFocus(model);
  const auto index = IndexCameras(model);
  std::vector<const Camera*> cameras;
  for (const PosedImage& image : model.images) {
    cameras.push_back(&model.cameras[index.at(image.camera_id)]);
  }
  std::vector<Point3D> points(std::max(0, count));
  for (size_t i = 0; i < points.size(); ++i) {
    points[i].id = i + 1;
    points[i].rgb = {128, 128, 128};
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const uint64_t counter = i * kAttempts + attempt;
      // The last attempt of a ball nobody sees falls back to a ray.
      const bool ball = i % 2 == 0 && attempt + 1 < kAttempts;
      points[i].xyz = ball ? InBall(focus, seed, counter)
                           : OnRay(model, cameras, focus, seed, counter);
      if (!ball || IsSeen(model, cameras, points[i].xyz)) break;
    }
  }
  return points;
}

}  // namespace freegs::sfm
