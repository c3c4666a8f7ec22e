// SPDX-License-Identifier: BSD-3-Clause
// The types of ewa_projection-inl.h, for any number type T: float, double, a
// SIMD vector of floats, or a Ceres Jet.

#ifndef FREEGS_SPLAT_PROJECTION_EWA_PROJECTION_H_
#define FREEGS_SPLAT_PROJECTION_EWA_PROJECTION_H_

#include <utility>

namespace freegs::splat {

// The type of a comparison of two numbers of type T: bool, or one bool per lane
// of a SIMD vector.
template <typename T>
using ComparisonOf = decltype(std::declval<T>() > std::declval<T>());

// A camera and its pose as plain numbers of type T. "World" is the frame of the
// model here (splat/scene/model_frame.h).
template <typename T>
struct ProjectionCamera {
  T rotation[9];     // World to camera, row-major.
  T translation[3];  // World to camera.
  T centre[3];       // Camera centre in the world.
  T fx, fy, cx, cy;  // Pixels.
  // J is taken at the mean as long as x/z and y/z are within these bounds, else
  // at the bound: far outside the image the affine approximation would become
  // arbitrarily large.
  T min_u, max_u, min_v, max_v;
  T near_plane;  // Units of that frame.
  T dilation;    // Variance in square pixels added to Sigma'.
};

// The image of a Gaussian.
template <typename T>
struct ProjectedGaussian {
  T mean[2];  // Pixels; the top-left pixel's centre is (0.5, 0.5).
  T depth;    // z in the camera frame.
  T cov[3];   // xx, xy, yy of Sigma' with dilation, square pixels.
  // d^T Sigma'^-1 d = conic_xx (dx + shear dy)^2 + precision_y dy^2, as in
  // Splat.
  T conic_xx, shear, precision_y;
};

// The derivatives of the loss L with respect to a ProjectedGaussian.
template <typename T>
struct ProjectedGradient {
  T mean[2];
  T depth;
  // What goes through Sigma'^-1, as the second moments of Splat: the sums of
  // q e^2, q e dy, q dy^2 over the pixels.
  T moments[3];
  // With respect to the LogOpacityFilter of antialiased Gaussians, 0 for
  // others.
  T log_filter;
};

// Intermediate results of the projection that its derivative needs again.
template <typename T>
struct ProjectionTerms {
  T camera_point[3];               // Mean in the camera frame.
  T u, v;                          // x/z and y/z, within the bounds.
  ComparisonOf<T> u_free, v_free;  // Whether they were within them already.
  T quaternion[4];                 // Normalised.
  T inverse_norm;                  // 1 / |q|.
  T rotation[9];                   // Rotation of the Gaussian, 3 x 3.
  T scale[3];                      // exp(log_scale).
  T world_to_image[6];             // J W, 2 x 3.
  T half[6];      // A = J W R S, 2 x 3: Sigma' = A A^T + dilation I.
  T cross[3];     // Cross product of the rows of A.
  T determinant;  // Determinant of Sigma'.
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_PROJECTION_EWA_PROJECTION_H_
