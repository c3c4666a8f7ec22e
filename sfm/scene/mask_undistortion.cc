// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/scene/mask_undistortion.h"

#include <optional>

#include <Eigen/Core>

namespace freegs::sfm {

ImageU8 UndistortMask(const ImageU8& mask,
                      const Camera& camera,
                      const Camera& pinhole) {
  ImageU8 result(
      static_cast<int>(pinhole.width), static_cast<int>(pinhole.height), 1);
  for (int y = 0; y < result.height(); ++y) {
    for (int x = 0; x < result.width(); ++x) {
      const Eigen::Vector3d ray(
          (x + 0.5 - pinhole.PrincipalX()) / pinhole.FocalX(),
          (y + 0.5 - pinhole.PrincipalY()) / pinhole.FocalY(),
          1);
      const std::optional<Eigen::Vector2d> pixel = Project(camera, ray);
      const bool inside = pixel && pixel->x() >= 0 && pixel->y() >= 0 &&
                          pixel->x() < mask.width() &&
                          pixel->y() < mask.height();
      if (inside && mask(static_cast<int>(pixel->x()),
                         static_cast<int>(pixel->y())) != 0) {
        result(x, y) = 255;
      }
    }
  }
  return result;
}

}  // namespace freegs::sfm
