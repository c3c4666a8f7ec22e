// SPDX-License-Identifier: BSD-3-Clause
// Points on the surfaces that the model shows, spread over the pictures evenly:
// where to start the Gaussians again (Fang and Wang 2024, Mini-Splatting,
// section 4.1, depth reinitialisation).

#ifndef FREEGS_SPLAT_DENSITY_DEPTH_REINITIALIZATION_H_
#define FREEGS_SPLAT_DENSITY_DEPTH_REINITIALIZATION_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "splat/render/contributions.h"
#include "splat/scene/gaussian_model.h"
#include "splat/scene/initialization.h"

namespace freegs::splat {

// Distance along a ray (origin and unit direction in the world frame) of the
// point of maximal density of a Gaussian, which is the middle between the two
// intersections of the ray with its ellipsoid:
//   t = d^T A (mu - o) / (d^T A d),  A = Sigma^-1.
// Negative behind the origin. Standard deviations below a millionth of the
// largest are taken as that. Also defined for a ray that passes beside the
// ellipsoid, where the renderer's dilation lets it blend: t is then bounded to
// the ball around the mean that holds the Gaussian (3.33 of the largest
// standard deviation, where alpha falls to 1/255), for a ray that grazes a flat
// Gaussian would meet its plane anywhere. Nothing when a parameter is not
// finite or the rotation is zero.
std::optional<double> MidpointDistance(const GaussianModel& model,
                                       size_t index,
                                       const Eigen::Vector3d& origin,
                                       const Eigen::Vector3d& direction);

// Coloured points in the world frame; the arrays are parallel.
struct DepthPoints {
  std::vector<Eigen::Vector3d> positions;
  std::vector<std::array<float, 3>> colors;  // RGB of the photo, in [0, 1].

  size_t size() const { return positions.size(); }

  // Adds those of another view.
  void Append(const DepthPoints& other);
};

// Draws `count` pixels of a view without replacement, with a probability
// proportional to their accumulated opacity (1 - transmittance), and gives the
// midpoint of the dominant Gaussian on the ray through the pixel's centre, in
// the photo's colour there; in row-major order. Pixels without a dominant
// Gaussian, and those whose midpoint is nearer than `near_plane` (z in the
// camera frame, world units), are left out before drawing: fewer points than
// `count` when fewer pixels remain. Random numbers are a function of
// (seed, stream, pixel): give each view and restart a stream of its own.
// kInvalidArgument unless the arrays of `contributions`, the RGB photo and the
// view's camera are of one size.
StatusOr<DepthPoints> SampleDepthPoints(const GaussianModel& model,
                                        const View& view,
                                        const ViewContributions& contributions,
                                        const ImageF& photo,
                                        double near_plane,
                                        size_t count,
                                        uint64_t seed,
                                        uint64_t stream);

// Sum over the pixels with a dominant Gaussian of the accumulated opacity.
double AccumulatedOpacity(const ViewContributions& contributions);

// Shares `total` points among views in proportion to `opacity`, the accumulated
// opacity of each (largest remainders, ties to the first): as every pixel of
// all views together had the same chance per opacity. Sums to `total`, unless
// no view shows anything: all zeros then. Values that are negative or not
// finite count as 0.
std::vector<size_t> PointsPerView(std::span<const double> opacity,
                                  size_t total);

// The model to go on with: InitializeFromPoints for these points.
StatusOr<GaussianModel> RestartFromDepthPoints(
    const DepthPoints& points,
    double scene_extent,
    const InitializationOptions& options = {});

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_DENSITY_DEPTH_REINITIALIZATION_H_
