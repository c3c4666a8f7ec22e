// SPDX-License-Identifier: BSD-3-Clause
// Keeps the space around each camera free of Gaussians. Nothing stood there
// when the photo was taken; a Gaussian there is a floater that training
// invented to match a few photos.

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
  // The radius of the empty ball around a camera is `factor` times a distance
  // d. The share near_quantile of the points in the camera's picture is nearer
  // than d: wrong matches put single points anywhere, so the nearest point says
  // little. Surfaces without texture have no points and may be nearer than all
  // of them; a factor of a quarter leaves room for these. 0 keeps no space
  // clear.
  double factor = 0.25;
  double near_quantile = 0.02;

  Status Check() const;
};

// A ball in which no Gaussian's centre is allowed. In the model frame
// (splat/scene/model_frame.h).
struct ClearBall {
  Eigen::Vector3f centre = Eigen::Vector3f::Zero();
  float radius = 0;
};

// Each view looks at no more points than these. Where a model has more, points
// at even steps through its list stand for all.
inline constexpr size_t kMaxClearancePoints = 200000;

// Returns one ball for each view that has any of the points inside its image,
// even if other things hide them. The points are the means of `points`, the
// model that training begins with. Takes time in proportion to views times
// points, of which there are kMaxClearancePoints at most.
std::vector<ClearBall> ClearBalls(const CameraClearanceOptions& options,
                                  std::span<const View> views,
                                  const GaussianModel& points,
                                  ThreadPool& pool);

// Returns the indices of the Gaussians outside all balls, ascending. The balls
// are finite and their radii above 0, as ClearBalls makes them. A Gaussian is
// compared with the balls near it, so the time is in proportion to Gaussians
// plus balls, as long as few balls overlap. The result is the same for any
// number of threads.
std::vector<uint32_t> OutsideBalls(std::span<const ClearBall> balls,
                                   const GaussianModel& model,
                                   ThreadPool& pool);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_DENSITY_CAMERA_CLEARANCE_H_
