// SPDX-License-Identifier: BSD-3-Clause
// Models of the same photos that do not quite agree.

#ifndef FREEGS_TESTS_SFM_MOVED_PHOTOS_H_
#define FREEGS_TESTS_SFM_MOVED_PHOTOS_H_

#include <numbers>

#include <Eigen/Geometry>

#include "core/rigid3d.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// The cameras of a model in a world that is turned, moved and three times as
// large. Its points stay.
inline Reconstruction InAnotherWorld(Reconstruction model) {
  Sim3d there_from_here;
  there_from_here.scale = 3;
  there_from_here.rotation =
      Eigen::Quaterniond(0.3, -0.5, 0.7, 0.2).normalized();
  there_from_here.translation = {10, -20, 5};
  for (PosedImage& image : model.images) {
    image.cam_from_world =
        TransformCamera(there_from_here, image.cam_from_world);
  }
  return model;
}

// Puts a photo (by its place in the list) to another side of the world, each to
// one of its own.
inline void MovePhoto(size_t index, Reconstruction* model) {
  const double angle = 1.5 + 0.3 * static_cast<double>(index);
  Rigid3d& pose = model->images[index].cam_from_world;
  pose.rotation = pose.rotation * Eigen::Quaterniond(Eigen::AngleAxisd(
                                      angle, Eigen::Vector3d::UnitZ()));
}

// Turns a photo where it is.
inline void TurnPhoto(size_t index, double degrees, Reconstruction* model) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(
      degrees * std::numbers::pi / 180, Eigen::Vector3d::UnitY()));
  Rigid3d& pose = model->images[index].cam_from_world;
  pose.rotation = turn * pose.rotation;
  pose.translation = turn * pose.translation;
}

}  // namespace freegs::sfm

#endif  // FREEGS_TESTS_SFM_MOVED_PHOTOS_H_
