// SPDX-License-Identifier: BSD-3-Clause
// A small reconstruction with exact projections, for tests.

#ifndef FREEGS_TESTS_SFM_SYNTHETIC_MODEL_H_
#define FREEGS_TESTS_SFM_SYNTHETIC_MODEL_H_

#include <cmath>
#include <cstdio>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/random.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

inline Rigid3d LookAt(const Eigen::Vector3d& centre,
                      const Eigen::Vector3d& target) {
  const Eigen::Vector3d z = (target - centre).normalized();
  const Eigen::Vector3d x =
      z.cross(Eigen::Vector3d(0.01, -0.02, 1)).normalized();
  Eigen::Matrix3d rotation;
  rotation.row(0) = x;
  rotation.row(1) = z.cross(x);
  rotation.row(2) = z;
  Rigid3d pose;
  pose.rotation = Eigen::Quaterniond(rotation);
  pose.translation = -(pose.rotation * centre);
  return pose;
}

inline std::string PhotoName(int i) {
  char name[32];
  std::snprintf(name, sizeof(name), "photo_%03d.jpg", i);
  return name;
}

// The ids of all pairs of the first 50 photos, the smaller one first.
inline std::set<std::pair<uint32_t, uint32_t>> AllPairs() {
  std::set<std::pair<uint32_t, uint32_t>> pairs;
  for (uint32_t i = 1; i <= 50; ++i) {
    for (uint32_t j = i + 1; j <= 50; ++j) pairs.emplace(i, j);
  }
  return pairs;
}

// num_images cameras on a circle of radius 4 around the origin, which look at
// it, and num_points points within a cube of side 2; all see all.
inline Reconstruction SyntheticModel(int num_images,
                                     int num_points,
                                     CameraModel model = CameraModel::kRadial) {
  Reconstruction result;
  Camera camera;
  camera.id = 1;
  camera.model = model;
  camera.width = 640;
  camera.height = 480;
  const CameraModelInfo& info = GetCameraModel(model);
  camera.params.assign(info.num_params, 0.01);
  for (int i = 0; i < info.num_focal; ++i) camera.params[i] = 600 + i;
  camera.params[info.num_focal] = 322;
  camera.params[info.num_focal + 1] = 239;
  if (model == CameraModel::kFov) camera.params.back() = 0.5;
  result.cameras.push_back(camera);

  RandomStream random(7, 1);
  for (int k = 0; k < num_points; ++k) {
    Point3D point;
    point.id = 10 + k;
    point.xyz = {2 * random.Uniform() - 1,
                 2 * random.Uniform() - 1,
                 2 * random.Uniform() - 1};
    point.rgb = {static_cast<uint8_t>(k), 100, 200};
    point.error = 0.5;
    result.points3d.push_back(point);
  }
  for (int i = 0; i < num_images; ++i) {
    PosedImage image;
    image.id = i + 1;
    image.camera_id = 1;
    image.name = PhotoName(i);
    const double angle = 2 * std::numbers::pi * i / num_images;
    image.cam_from_world =
        LookAt({4 * std::cos(angle), 4 * std::sin(angle), 1.5 + 0.1 * i},
               Eigen::Vector3d::Zero());
    for (Point3D& point : result.points3d) {
      const auto pixel = Project(camera, image.cam_from_world * point.xyz);
      if (!pixel) continue;
      point.track.push_back(
          {image.id, static_cast<uint32_t>(image.points2d.size())});
      image.points2d.push_back({*pixel, point.id});
    }
    // A feature without a point.
    image.points2d.push_back({{1.5, 2.5}, kNoPoint3D});
    result.images.push_back(std::move(image));
  }
  return result;
}

}  // namespace freegs::sfm

#endif  // FREEGS_TESTS_SFM_SYNTHETIC_MODEL_H_
