// SPDX-License-Identifier: BSD-3-Clause
// Small random scenes for renderer tests.

#ifndef FREEGS_TESTS_SPLAT_TEST_SCENE_H_
#define FREEGS_TESTS_SPLAT_TEST_SCENE_H_

#include <cmath>

#include "core/pinhole.h"
#include "core/random.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

// `count` Gaussians in front of the camera of TestCamera, some partly outside
// the image, of mixed size, anisotropy and opacity.
inline GaussianModel RandomSceneModel(size_t count,
                                      int sh_degree,
                                      uint64_t seed) {
  GaussianModel model;
  model.sh_degree = sh_degree;
  model.Resize(count);
  RandomStream random(seed, 0);
  const auto uniform = [&](double lo, double hi) {
    return static_cast<float>(lo + (hi - lo) * random.Uniform());
  };
  for (size_t i = 0; i < count; ++i) {
    model.means[3 * i] = uniform(-1.6, 1.6);
    model.means[3 * i + 1] = uniform(-1.2, 1.2);
    model.means[3 * i + 2] = uniform(-1.0, 2.0);
    for (int k = 0; k < 3; ++k) {
      model.log_scales[3 * i + k] = uniform(std::log(0.01), std::log(0.35));
      model.sh_dc[3 * i + k] = uniform(-1.0, 2.0);
    }
    for (int k = 0; k < 4; ++k) {
      model.rotations[4 * i + k] = static_cast<float>(random.Normal());
    }
    model.opacity_logits[i] = uniform(-3.0, 5.0);
  }
  for (float& v : model.sh_rest) v = uniform(-0.3, 0.3);
  return model;
}

inline Pinhole TestCamera(int width, int height) {
  return {width,
          height,
          0.9 * width,
          0.95 * width,
          0.5 * width + 1.3,
          0.5 * height - 0.7};
}

inline Rigid3d TestPose() {
  Rigid3d pose;
  pose.rotation = Eigen::Quaterniond(
      Eigen::AngleAxisd(0.15, Eigen::Vector3d(0.3, 1.0, -0.4).normalized()));
  pose.translation = Eigen::Vector3d(0.1, -0.05, 3.0);
  return pose;
}

}  // namespace freegs::splat

#endif  // FREEGS_TESTS_SPLAT_TEST_SCENE_H_
