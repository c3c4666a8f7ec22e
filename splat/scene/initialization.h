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

  // Neighbours whose distance sets the size of a Gaussian.
  int num_neighbours = 3;

  // Bounds of the standard deviations; shares of the scene extent. They catch
  // points that coincide and lone points far outside.
  double min_scale = 1e-5;
  double max_scale = 1.0;

  // SH degree stored; coefficients above degree 0 start at zero.
  int sh_degree = 0;

  Status Check() const;
};

// One isotropic Gaussian per point: its standard deviation is the root mean
// square distance to the nearest neighbours at other positions (exact search),
// its colour the point's. `positions` (world) and `colors` (RGB, 0..255) are
// parallel. Points that are not finite are left out. kBadInput when no point
// remains.
StatusOr<GaussianModel> InitializeFromPoints(
    std::span<const Eigen::Vector3d> positions,
    std::span<const std::array<uint8_t, 3>> colors,
    double scene_extent,
    const InitializationOptions& options = {});

// The same with colours as they are stored: SH coefficients of degree 0 (r g b,
// see kShC0), kept to the last bit. Points whose colour is not finite are left
// out as well.
StatusOr<GaussianModel> InitializeFromShDc(
    std::span<const Eigen::Vector3d> positions,
    std::span<const std::array<float, 3>> sh_dc,
    double scene_extent,
    const InitializationOptions& options = {});

// The length unit of the optimisation: 1.1 times the largest distance of a
// camera from the mean camera centre (3DGS). Where all cameras coincide: the
// median distance of the points from the mean camera centre, or 1 without
// points. Positive and finite.
double SceneExtent(std::span<const View> views,
                   std::span<const Eigen::Vector3d> points);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_SCENE_INITIALIZATION_H_
