// SPDX-License-Identifier: BSD-3-Clause
// The types of ewa_projection-inl.h, for any number type T: float, double, a
// SIMD vector of floats, or a Ceres Jet.

#ifndef FREEGS_SPLAT_PROJECTION_EWA_PROJECTION_H_
#define FREEGS_SPLAT_PROJECTION_EWA_PROJECTION_H_

#include <utility>

namespace freegs::splat {

// What comparing two numbers of type T gives: bool, or a mask of lanes.
template <typename T>
using ComparisonOf = decltype(std::declval<T>() > std::declval<T>());

// The camera as the kernels want it: plain numbers of type T.
template <typename T>
struct ProjectionCamera {
  T rotation[9];     // World to camera, row-major.
  T translation[3];  // World to camera.
  T centre[3];       // Camera centre in the world.
  T fx, fy, cx, cy;  // Pixels.
  // Bounds of x/z and y/z inside which J follows the mean. Outside (far off the
  // image) the affine approximation explodes, so J is taken at the bound.
  T min_u, max_u, min_v, max_v;
  T near_plane;  // World units.
  T dilation;    // Variance in square pixels added to Sigma'.
};

// A Gaussian in the image.
template <typename T>
struct ProjectedGaussian {
  T mean[2];   // Pixels; the top-left pixel's centre is (0.5, 0.5).
  T depth;     // z in the camera frame.
  T cov[3];    // xx, xy, yy of Sigma' with dilation, square pixels.
  T conic[3];  // xx, xy, yy of its inverse.
};

// dL / d(ProjectedGaussian), as the rasteriser delivers it. conic[1] is the
// derivative with respect to the one off-diagonal number.
template <typename T>
struct ProjectedGradient {
  T mean[2];
  T depth;
  T conic[3];
};

// What the backward pass needs again and would otherwise recompute.
template <typename T>
struct ProjectionTerms {
  T camera_point[3];               // Mean in the camera frame.
  T u, v;                          // x/z and y/z, bounded.
  ComparisonOf<T> u_free, v_free;  // Whether the bound was inactive.
  T quaternion[4];                 // Normalised.
  T inverse_norm;                  // 1 / |q|.
  T rotation[9];                   // Of the Gaussian.
  T scale[3];                      // exp(log_scale).
  T world_to_image[6];             // J W, 2 x 3.
  T half[6];  // A = J W R S, 2 x 3: Sigma' = A A^T + dilation I.
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_PROJECTION_EWA_PROJECTION_H_
