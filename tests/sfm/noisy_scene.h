// SPDX-License-Identifier: BSD-3-Clause
// Photos of a ball of points with noise and outliers, for tests of estimation.

#ifndef FREEGS_TESTS_SFM_NOISY_SCENE_H_
#define FREEGS_TESTS_SFM_NOISY_SCENE_H_

#include <cmath>
#include <numbers>
#include <vector>

#include "core/random.h"
#include "sfm/scene/camera_conversion.h"
#include "sfm/scene/reconstruction.h"
#include "tests/sfm/synthetic_model.h"

namespace freegs::sfm {

struct NoisyScene {
  int num_images = 12;
  int num_points = 400;
  double noise_px = 0.5;   // Standard deviation of each coordinate.
  double outliers = 0.03;  // Share of observations, up to 20 px off.

  // The distance of the nearest camera from the centre of the ball, whose
  // radius is 2.5.
  double distance = 3.5;

  // Camera k belongs to the images i with i % cameras.size() == k.
  std::vector<Camera> cameras;

  double pose_error = 0.01;   // In the start: radians, and world units.
  double point_error = 0.01;  // In the start: world units.
};

inline Camera MakeCamera(CameraModel model, std::vector<double> params) {
  Camera camera;
  camera.id = 1;
  camera.model = model;
  camera.width = 640;
  camera.height = 480;
  camera.params = std::move(params);
  return camera;
}

// Drawn one after the other: the order in which a compiler evaluates arguments
// is its own choice, and all compilers shall draw the same scene.
template <typename Draw>
Eigen::Vector3d DrawVector3(const Draw& draw) {
  Eigen::Vector3d vector;
  for (double& x : vector) x = draw();
  return vector;
}

// The truth: exact poses and points. Its features have noise.
inline Reconstruction MakeNoisyScene(const NoisyScene& scene) {
  Reconstruction model;
  for (size_t k = 0; k < scene.cameras.size(); ++k) {
    model.cameras.push_back(scene.cameras[k]);
    model.cameras.back().id = static_cast<uint32_t>(k) + 1;
  }
  RandomStream random(11, 5);
  const auto centred = [&] { return random.Uniform() - 0.5; };
  for (int k = 0; k < scene.num_points; ++k) {
    Point3D point;
    point.id = 3 * k + 1;
    do {
      point.xyz = 5 * DrawVector3(centred);
    } while (point.xyz.norm() > 2.5);
    model.points3d.push_back(point);
  }
  for (int i = 0; i < scene.num_images; ++i) {
    PosedImage image;
    const Camera& camera = model.cameras[i % model.cameras.size()];
    image.id = i + 1;
    image.camera_id = camera.id;
    image.name = PhotoName(i);
    const double angle = 2 * std::numbers::pi * i / scene.num_images;
    const double distance = scene.distance + random.Uniform();
    const double height = 2 * random.Uniform() - 0.5;
    image.cam_from_world =
        LookAt({distance * std::cos(angle), distance * std::sin(angle), height},
               DrawVector3(centred));
    for (Point3D& point : model.points3d) {
      const auto pixel = Project(camera, image.cam_from_world * point.xyz);
      if (!pixel || (pixel->array() < 0).any() || pixel->x() > camera.width ||
          pixel->y() > camera.height) {
        continue;
      }
      Eigen::Vector2d xy = *pixel;
      if (random.Uniform() < scene.outliers) {
        for (double& x : xy) x += 40 * centred();
      } else {
        for (double& x : xy) x += scene.noise_px * random.Normal();
      }
      point.track.push_back(
          {image.id, static_cast<uint32_t>(image.points2d.size())});
      image.points2d.push_back({xy, point.id});
    }
    model.images.push_back(std::move(image));
  }
  return model;
}

// What a mapper that knows only RADIAL might have made of it.
inline Reconstruction MakeStart(const NoisyScene& scene,
                                const Reconstruction& truth) {
  Reconstruction start = truth;
  RandomStream random(13, 6);
  const auto vector = [&](double size) {
    return DrawVector3([&] { return size * random.Normal(); });
  };
  for (PosedImage& image : start.images) {
    const Eigen::Vector3d turn = vector(scene.pose_error);
    if (turn.norm() > 0) {
      image.cam_from_world.rotation =
          Eigen::AngleAxisd(turn.norm(), turn.normalized()) *
          image.cam_from_world.rotation;
    }
    image.cam_from_world.translation += vector(scene.pose_error);
  }
  for (Point3D& point : start.points3d) point.xyz += vector(scene.point_error);
  for (Camera& camera : start.cameras) {
    camera = ConvertCamera(camera, CameraModel::kRadial);
    camera.params[0] *= 1.01;
  }
  return start;
}

}  // namespace freegs::sfm

#endif  // FREEGS_TESTS_SFM_NOISY_SCENE_H_
