// SPDX-License-Identifier: BSD-3-Clause
// Small Gaussian scenes with known instances.

#ifndef FREEGS_TESTS_SEMANTICS_SYNTHETIC_GAUSSIANS_H_
#define FREEGS_TESTS_SEMANTICS_SYNTHETIC_GAUSSIANS_H_

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/pinhole.h"
#include "core/random.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::semantics {

// Gaussians and the object each belongs to.
class SyntheticGaussians {
 public:
  splat::GaussianModel model;
  std::vector<int32_t> truth;

  void Add(const Eigen::Vector3d& position,
           const Eigen::Vector3d& color,
           double scale,
           double opacity,
           int32_t object) {
    for (int k = 0; k < 3; ++k) {
      model.means.push_back(static_cast<float>(position[k]));
      model.log_scales.push_back(static_cast<float>(std::log(scale)));
      model.sh_dc.push_back(
          static_cast<float>((color[k] - 0.5) / splat::kShC0));
    }
    for (const float q : {1.0f, 0.0f, 0.0f, 0.0f}) model.rotations.push_back(q);
    model.opacity_logits.push_back(
        static_cast<float>(std::log(opacity / (1 - opacity))));
    truth.push_back(object);
  }

  // A horizontal square of the given side, with thickness noise.
  void AddSquare(const Eigen::Vector3d& center,
                 double side,
                 const Eigen::Vector3d& color,
                 int count,
                 int32_t object) {
    for (int i = 0; i < count; ++i) {
      Add(center + Eigen::Vector3d(side * (Uniform() - 0.5),
                                   side * (Uniform() - 0.5),
                                   0.003 * Normal()),
          Textured(color),
          0.01,
          0.9,
          object);
    }
  }

  void AddSphere(const Eigen::Vector3d& center,
                 double radius,
                 const Eigen::Vector3d& color,
                 int count,
                 int32_t object) {
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d direction(Normal(), Normal(), Normal());
      Add(center + (radius + 0.003 * Normal()) * direction.normalized(),
          Textured(color),
          0.01,
          0.9,
          object);
    }
  }

  double Uniform() { return RandomUniform(11, 0, counter_++); }
  double Normal() { return RandomNormal(11, 1, counter_++); }

 private:
  // Spots darker than the rest.
  Eigen::Vector3d Textured(const Eigen::Vector3d& color) {
    const double shade = Uniform() < 0.3 ? 0.6 : 1.0;
    Eigen::Vector3d result;
    for (int k = 0; k < 3; ++k) {
      result[k] = std::clamp(shade * color[k] + 0.03 * Normal(), 0.0, 1.0);
    }
    return result;
  }

  uint64_t counter_ = 0;
};

// A table of side 2 at height 0 and four balls that touch it: three of radius
// 0.15, two of these 8 cm apart, and one of 0.1. Haze above.
inline SyntheticGaussians MakeTableScene() {
  SyntheticGaussians scene;
  scene.AddSquare({0, 0, 0}, 2, {0.5, 0.35, 0.2}, 8000, 0);
  scene.AddSphere({0.5, 0.5, 0.15}, 0.15, {0.8, 0.1, 0.1}, 1200, 1);
  scene.AddSphere({-0.53, 0.4, 0.15}, 0.15, {0.1, 0.7, 0.1}, 1100, 2);
  scene.AddSphere({-0.15, 0.4, 0.15}, 0.15, {0.1, 0.2, 0.8}, 1000, 3);
  scene.AddSphere({0.1, -0.5, 0.1}, 0.1, {0.9, 0.9, 0.9}, 700, 4);
  for (int i = 0; i < 150; ++i) {
    scene.Add({2 * scene.Uniform() - 1,
               2 * scene.Uniform() - 1,
               1.5 * scene.Uniform()},
              {0.5, 0.5, 0.5},
              0.05,
              0.03,
              -1);
  }
  return scene;
}

// A camera of 80 x 60 pixels, 2.8 away from the origin, that looks down on it.
inline View LookAtOrigin(double heading) {
  const Eigen::Vector3d center(
      2.2 * std::cos(heading), 2.2 * std::sin(heading), 1.8);
  const Eigen::Vector3d forward = -center.normalized();
  const Eigen::Vector3d right =
      forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d rotation;
  rotation.row(0) = right.transpose();
  rotation.row(1) = forward.cross(right).transpose();
  rotation.row(2) = forward.transpose();
  View view;
  view.camera = {80, 60, 70, 70, 40, 30};
  view.cam_from_world.rotation = Eigen::Quaterniond(rotation);
  view.cam_from_world.translation = -(rotation * center);
  return view;
}

}  // namespace freegs::semantics

#endif  // FREEGS_TESTS_SEMANTICS_SYNTHETIC_GAUSSIANS_H_
