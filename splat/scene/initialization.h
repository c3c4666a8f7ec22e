// SPDX-License-Identifier: BSD-3-Clause
// The first Gaussians, from the points of structure from motion.

#ifndef FREEGS_SPLAT_SCENE_INITIALIZATION_H_
#define FREEGS_SPLAT_SCENE_INITIALIZATION_H_

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "core/pinhole.h"
#include "core/status.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

struct InitializationOptions {
  // Opacity of every Gaussian, in (0, 1).
  double opacity = 0.1;

  // Number of nearest points whose distances set the size of a Gaussian.
  int num_neighbours = 3;

  // Smallest and largest standard deviation, as shares of the scene extent.
  // Without them, points that coincide would give Gaussians of no size, and
  // lone points far outside the scene would give huge ones.
  double min_scale = 1e-5;
  double max_scale = 1.0;

  // SH degree of the model. Coefficients above degree 0 start at zero.
  int sh_degree = 0;

  Status Check() const;
};

// Makes one isotropic Gaussian per point, of the point's colour. Its standard
// deviation is the root mean square distance to the nearest points at other
// positions. `positions` are in the model frame (splat/scene/model_frame.h);
// `colors` are RGB in 0..255 and parallel to them, where 0 counts as 1. Points
// that are not finite are left out. Fails with kBadInput when no point remains.
StatusOr<GaussianModel> InitializeFromPoints(
    std::span<const Eigen::Vector3d> positions,
    std::span<const std::array<uint8_t, 3>> colors,
    double scene_extent,
    const InitializationOptions& options = {});

// Like InitializeFromPoints, but the colours are SH coefficients of degree 0
// (r g b, see kShC0), which the model takes over bit for bit unless they are
// those of a channel below 1/255: these are raised to it, so that it has a
// gradient. Points whose colour is not finite are left out as well.
StatusOr<GaussianModel> InitializeFromShDc(
    std::span<const Eigen::Vector3d> positions,
    std::span<const std::array<float, 3>> sh_dc,
    double scene_extent,
    const InitializationOptions& options = {});

// The size of the scene in units of the model frame, which learning rates and
// thresholds are relative to: 1.1 times the largest distance of a camera from
// the mean camera centre, as in 3DGS. When all cameras coincide it is the
// median distance of the points from the mean camera centre, or 1 when there
// are no points. The result is positive and finite.
double SceneExtent(std::span<const View> views,
                   std::span<const Eigen::Vector3d> points);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_SCENE_INITIALIZATION_H_
