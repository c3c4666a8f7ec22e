// SPDX-License-Identifier: BSD-3-Clause
// Draws points on the surfaces that the model shows, spread evenly over the
// pictures, and starts the Gaussians again from them: the depth
// reinitialisation of Mini-Splatting (Fang and Wang 2024, section 4.1).

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

// Returns the distance t along a ray, with origin o and unit direction d in the
// model frame (splat/scene/model_frame.h), at which the density of a Gaussian
// is largest. This is the middle between the two intersections of the ray with
// its ellipsoid:
//   t = d^T A (mu - o) / (d^T A d),  A = Sigma^-1.
// t is negative behind the origin. Standard deviations below a millionth of the
// largest count as a millionth of it.
//
// A ray that passes beside the ellipsoid has a t as well, for the renderer's
// dilation blends the Gaussian there too. But a ray that grazes a flat Gaussian
// meets its plane arbitrarily far away, so t is limited to the ball around the
// mean that holds the Gaussian: its radius is 3.33 times the largest standard
// deviation, where alpha falls to 1/255.
//
// Returns nothing when a parameter is not finite or the rotation is zero.
std::optional<double> MidpointDistance(const GaussianModel& model,
                                       size_t index,
                                       const Eigen::Vector3d& origin,
                                       const Eigen::Vector3d& direction);

// Coloured points in the model frame; the arrays are parallel.
struct DepthPoints {
  std::vector<Eigen::Vector3d> positions;
  std::vector<std::array<float, 3>> colors;  // RGB of the photo.

  size_t size() const { return positions.size(); }

  // Appends the points of another view.
  void Append(const DepthPoints& other);
};

// Draws `count` pixels of a view without replacement, with a probability in
// proportion to their accumulated opacity, 1 - transmittance. Returns, in
// row-major order, one point per pixel drawn: the midpoint (see
// MidpointDistance) of the pixel's dominant Gaussian on the ray through the
// pixel's centre, in the colour that the photo has there. Pixels without a
// dominant Gaussian, and those whose midpoint is nearer than `near_plane` (z in
// the camera frame, in units of the model frame), are left out before the draw;
// when fewer than `count` pixels remain, all of them are taken. Random numbers
// are a function of seed, stream and pixel, so each view and each restart needs
// a stream of its own. Fails with kInvalidArgument unless the arrays of
// `contributions`, the RGB photo and the view's camera have the same size.
StatusOr<DepthPoints> SampleDepthPoints(const GaussianModel& model,
                                        const View& view,
                                        const ViewContributions& contributions,
                                        const ImageF& photo,
                                        double near_plane,
                                        size_t count,
                                        uint64_t seed,
                                        uint64_t stream);

// The sum of the accumulated opacity over the pixels that have a dominant
// Gaussian.
double AccumulatedOpacity(const ViewContributions& contributions);

// Divides `total` points among the views in proportion to their accumulated
// opacity, as if the pixels were drawn from all views together. Rounds by the
// method of largest remainders; of equal remainders the first view wins. The
// numbers sum up to `total`, or are all zero when no view shows anything.
// Values that are negative or not finite count as 0.
std::vector<size_t> PointsPerView(std::span<const double> opacity,
                                  size_t total);

// Returns the model to go on with: what InitializeFromPoints makes of the
// points.
StatusOr<GaussianModel> RestartFromDepthPoints(
    const DepthPoints& points,
    double scene_extent,
    const InitializationOptions& options = {});

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_DENSITY_DEPTH_REINITIALIZATION_H_
