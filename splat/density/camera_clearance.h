// SPDX-License-Identifier: BSD-3-Clause
// The space around each camera that nothing stands in: a Gaussian there is a
// floater, made up to please the few pictures that look through it.

#ifndef FREEGS_SPLAT_DENSITY_CAMERA_CLEARANCE_H_
#define FREEGS_SPLAT_DENSITY_CAMERA_CLEARANCE_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

struct CameraClearanceOptions {
  // Radius of the empty ball around a camera, in terms of the distance that
  // this share of the points in its picture are nearer than: matches on the
  // wrong points put some of them anywhere. What has no texture may be nearer
  // than all points; a quarter leaves it room. 0 keeps nothing clear.
  double factor = 0.25;
  double near_quantile = 0.02;

  Status Check() const;
};

// A ball that holds no Gaussian's centre.
struct ClearBall {
  Eigen::Vector3f centre = Eigen::Vector3f::Zero();  // World frame.
  float radius = 0;                                  // World units.
};

// One ball for each view that shows any of the points, whatever may hide them.
// `points` are the means of the Gaussians that training begins with.
std::vector<ClearBall> ClearBalls(const CameraClearanceOptions& options,
                                  std::span<const View> views,
                                  const GaussianModel& points,
                                  ThreadPool& pool);

// The Gaussians outside all the balls, ascending. Time grows with Gaussians
// times balls. The same for any number of threads.
std::vector<uint32_t> OutsideBalls(std::span<const ClearBall> balls,
                                   const GaussianModel& model,
                                   ThreadPool& pool);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_DENSITY_CAMERA_CLEARANCE_H_
