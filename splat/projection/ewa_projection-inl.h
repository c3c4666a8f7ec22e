// SPDX-License-Identifier: BSD-3-Clause
// The projection of one Gaussian into one camera, and its derivative. These are
// templates so that the same code runs on SIMD vectors, on doubles and, in
// tests, on the automatic derivatives of Ceres.
//
// The method is EWA splatting (Zwicker et al. 2001) as used by 3DGS (Kerbl et
// al. 2023, section 4). With W the rotation from world to camera and J the
// affine approximation of the perspective projection at the mean, the
// covariance in the image is Sigma' = J W Sigma W^T J^T.

// Compiled anew for each instruction set: see hwy/highway.h on -inl.h files.
#if defined(FREEGS_SPLAT_PROJECTION_EWA_PROJECTION_INL_H_) == \
    defined(HWY_TARGET_TOGGLE)
#ifdef FREEGS_SPLAT_PROJECTION_EWA_PROJECTION_INL_H_
#undef FREEGS_SPLAT_PROJECTION_EWA_PROJECTION_INL_H_
#else
#define FREEGS_SPLAT_PROJECTION_EWA_PROJECTION_INL_H_
#endif

#include <cmath>

#include <hwy/highway.h>

#include "splat/projection/ewa_projection.h"

HWY_BEFORE_NAMESPACE();
namespace freegs::splat::HWY_NAMESPACE {

// Logic for plain numbers, whose comparisons give a bool. SIMD vectors have
// overloads of their own (simd_number-inl.h).
inline bool And(bool a, bool b) { return a && b; }
template <typename T>
T Select(bool condition, const T& yes, const T& no) {
  return condition ? yes : no;
}

template <typename T>
void RotationFromQuaternion(const T q[4], T r[9]) {
  const T w = q[0], x = q[1], y = q[2], z = q[3];
  r[0] = T(1) - T(2) * (y * y + z * z);
  r[1] = T(2) * (x * y - w * z);
  r[2] = T(2) * (x * z + w * y);
  r[3] = T(2) * (x * y + w * z);
  r[4] = T(1) - T(2) * (x * x + z * z);
  r[5] = T(2) * (y * z - w * x);
  r[6] = T(2) * (x * z - w * y);
  r[7] = T(2) * (y * z + w * x);
  r[8] = T(1) - T(2) * (x * x + y * y);
}

// Returns false, with undefined outputs, when the Gaussian lies nearer than the
// near plane or its image is degenerate.
template <typename T>
ComparisonOf<T> ProjectGaussian(const ProjectionCamera<T>& camera,
                                const T mean[3],
                                const T log_scale[3],
                                const T rotation[4],
                                ProjectedGaussian<T>* projected,
                                ProjectionTerms<T>* terms) {
  using std::exp;
  using std::sqrt;
  const T* w = camera.rotation;
  T* t = terms->camera_point;
  for (int i = 0; i < 3; ++i) {
    t[i] = w[3 * i] * mean[0] + w[3 * i + 1] * mean[1] +
           w[3 * i + 2] * mean[2] + camera.translation[i];
  }
  const T inverse_z = T(1) / t[2];
  T u = t[0] * inverse_z;
  T v = t[1] * inverse_z;
  projected->mean[0] = camera.fx * u + camera.cx;
  projected->mean[1] = camera.fy * v + camera.cy;
  projected->depth = t[2];
  terms->u_free = And(u > camera.min_u, camera.max_u > u);
  terms->v_free = And(v > camera.min_v, camera.max_v > v);
  u = Select(
      terms->u_free, u, Select(u > camera.min_u, camera.max_u, camera.min_u));
  v = Select(
      terms->v_free, v, Select(v > camera.min_v, camera.max_v, camera.min_v));
  terms->u = u;
  terms->v = v;

  const T squared_norm = rotation[0] * rotation[0] + rotation[1] * rotation[1] +
                         rotation[2] * rotation[2] + rotation[3] * rotation[3];
  terms->inverse_norm = T(1) / sqrt(squared_norm);
  for (int i = 0; i < 4; ++i) {
    terms->quaternion[i] = rotation[i] * terms->inverse_norm;
  }
  RotationFromQuaternion(terms->quaternion, terms->rotation);
  for (int i = 0; i < 3; ++i) terms->scale[i] = exp(log_scale[i]);

  const T j00 = camera.fx * inverse_z;
  const T j11 = camera.fy * inverse_z;
  T* k = terms->world_to_image;
  for (int i = 0; i < 3; ++i) {
    k[i] = j00 * (w[i] - u * w[6 + i]);
    k[3 + i] = j11 * (w[3 + i] - v * w[6 + i]);
  }
  T* a = terms->half;
  const T* r = terms->rotation;
  for (int row = 0; row < 2; ++row) {
    for (int i = 0; i < 3; ++i) {
      a[3 * row + i] = (k[3 * row] * r[i] + k[3 * row + 1] * r[3 + i] +
                        k[3 * row + 2] * r[6 + i]) *
                       terms->scale[i];
    }
  }
  T* cov = projected->cov;
  cov[0] = a[0] * a[0] + a[1] * a[1] + a[2] * a[2] + camera.dilation;
  cov[1] = a[0] * a[3] + a[1] * a[4] + a[2] * a[5];
  cov[2] = a[3] * a[3] + a[4] * a[4] + a[5] * a[5] + camera.dilation;
  // det(A A^T) is the squared length of the cross product of the rows of A.
  // So the determinant of Sigma' is a sum of positive numbers, which keeps its
  // digits where cov[0] cov[2] - cov[1]^2 loses all of them: with the long and
  // thin images of Gaussians right in front of the camera.
  const T x = a[1] * a[5] - a[2] * a[4];
  const T y = a[2] * a[3] - a[0] * a[5];
  const T z = a[0] * a[4] - a[1] * a[3];
  terms->sharp_determinant = x * x + y * y + z * z;
  const T determinant = terms->sharp_determinant +
                        camera.dilation * (cov[0] + cov[2] - camera.dilation);
  terms->determinant = determinant;
  const T inverse_determinant = T(1) / determinant;
  projected->conic[0] = cov[2] * inverse_determinant;
  projected->conic[1] = -cov[1] * inverse_determinant;
  projected->conic[2] = cov[0] * inverse_determinant;
  // Comparisons that fail for NaN.
  return And(And(t[2] > camera.near_plane, squared_norm > T(1e-20)),
             And(determinant > T(1e-12), T(1e30) > determinant));
}

// What the dilation takes off the opacity of an antialiased Gaussian, from the
// results of ProjectGaussian.
template <typename T>
OpacityFilter<T> FilterOpacity(const ProjectionCamera<T>& camera,
                               const ProjectedGaussian<T>& projected,
                               const ProjectionTerms<T>& terms) {
  using std::log;
  const T* c = projected.cov;
  const T sharp = terms.sharp_determinant;
  const T wide = terms.determinant;
  const T ratio = sharp / wide;
  const T least(2.5e-5);
  const auto free = ratio > least;
  OpacityFilter<T> filter;
  filter.log_factor = T(0.5) * log(Select(free, ratio, least));
  // d ln det(Sigma) / d Sigma = Sigma^-1.
  const T sharp_xx = (c[2] - camera.dilation) / sharp;
  const T sharp_yy = (c[0] - camera.dilation) / sharp;
  filter.cov[0] = Select(free, T(0.5) * (sharp_xx - c[2] / wide), T(0));
  filter.cov[1] = Select(free, T(0.5) * (c[1] / wide - c[1] / sharp), T(0));
  filter.cov[2] = Select(free, T(0.5) * (sharp_yy - c[0] / wide), T(0));
  return filter;
}

// The derivative of ProjectGaussian: from dL/d(projected) it adds to dL/dmean
// and dL/dlog_scale, and overwrites dL/drotation, the derivative with respect
// to the quaternion before normalisation.
template <typename T>
void BackwardProjectGaussian(const ProjectionCamera<T>& camera,
                             const ProjectedGaussian<T>& projected,
                             const ProjectionTerms<T>& terms,
                             const ProjectedGradient<T>& gradient,
                             T d_mean[3],
                             T d_log_scale[3],
                             T d_rotation[4]) {
  const T* w = camera.rotation;
  const T* c = projected.conic;
  // Sigma' = conic^-1, so dL/dSigma' = -conic * dL/dconic * conic with both
  // gradients as symmetric matrices (half of conic[1]'s in each corner).
  const T ga = gradient.conic[0];
  const T gb = gradient.conic[1] * T(0.5);
  const T gc = gradient.conic[2];
  const T m00 = c[0] * ga + c[1] * gb, m01 = c[0] * gb + c[1] * gc;
  const T m10 = c[1] * ga + c[2] * gb, m11 = c[1] * gb + c[2] * gc;
  const T s00 = gradient.cov[0] - (m00 * c[0] + m01 * c[1]);
  const T s01 = gradient.cov[1] - (m00 * c[1] + m01 * c[2]);
  const T s11 = gradient.cov[2] - (m10 * c[1] + m11 * c[2]);

  // Sigma' = A A^T: dL/dA = 2 dL/dSigma' A.
  const T* a = terms.half;
  T da[6];
  for (int i = 0; i < 3; ++i) {
    da[i] = T(2) * (s00 * a[i] + s01 * a[3 + i]);
    da[3 + i] = T(2) * (s01 * a[i] + s11 * a[3 + i]);
  }

  // A = K M with K = J W and M = R S.
  const T* k = terms.world_to_image;
  const T* r = terms.rotation;
  T dr[9];
  T dk[6] = {T(0), T(0), T(0), T(0), T(0), T(0)};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const T dm = k[i] * da[j] + k[3 + i] * da[3 + j];
      dr[3 * i + j] = dm * terms.scale[j];
      d_log_scale[j] += dm * r[3 * i + j] * terms.scale[j];
      dk[i] += da[j] * r[3 * i + j] * terms.scale[j];
      dk[3 + i] += da[3 + j] * r[3 * i + j] * terms.scale[j];
    }
  }

  // K = [fx/z (w0 - u w2); fy/z (w1 - v w2)].
  const T z = terms.camera_point[2];
  const T inverse_z = T(1) / z;
  T d_u = T(0), d_v = T(0), d_inverse_z = T(0);
  for (int i = 0; i < 3; ++i) {
    d_u -= dk[i] * camera.fx * inverse_z * w[6 + i];
    d_v -= dk[3 + i] * camera.fy * inverse_z * w[6 + i];
    d_inverse_z += dk[i] * camera.fx * (w[i] - terms.u * w[6 + i]) +
                   dk[3 + i] * camera.fy * (w[3 + i] - terms.v * w[6 + i]);
  }
  d_u = Select(terms.u_free, d_u, T(0));
  d_v = Select(terms.v_free, d_v, T(0));
  d_u += gradient.mean[0] * camera.fx;
  d_v += gradient.mean[1] * camera.fy;

  // u = x/z, v = y/z.
  T dt[3];
  dt[0] = d_u * inverse_z;
  dt[1] = d_v * inverse_z;
  dt[2] = gradient.depth - (d_u * terms.camera_point[0] +
                            d_v * terms.camera_point[1] + d_inverse_z) *
                               inverse_z * inverse_z;
  for (int i = 0; i < 3; ++i) {
    d_mean[i] += w[i] * dt[0] + w[3 + i] * dt[1] + w[6 + i] * dt[2];
  }

  // R(q), then q / |q|.
  const T qw = terms.quaternion[0], qx = terms.quaternion[1];
  const T qy = terms.quaternion[2], qz = terms.quaternion[3];
  T dq[4];
  dq[0] = T(2) *
          (qx * (dr[7] - dr[5]) + qy * (dr[2] - dr[6]) + qz * (dr[3] - dr[1]));
  dq[1] = T(2) * (qw * (dr[7] - dr[5]) + qy * (dr[1] + dr[3]) +
                  qz * (dr[2] + dr[6]) - T(2) * qx * (dr[4] + dr[8]));
  dq[2] = T(2) * (qw * (dr[2] - dr[6]) + qx * (dr[1] + dr[3]) +
                  qz * (dr[5] + dr[7]) - T(2) * qy * (dr[0] + dr[8]));
  dq[3] = T(2) * (qw * (dr[3] - dr[1]) + qx * (dr[2] + dr[6]) +
                  qy * (dr[5] + dr[7]) - T(2) * qz * (dr[0] + dr[4]));
  const T along = dq[0] * qw + dq[1] * qx + dq[2] * qy + dq[3] * qz;
  for (int i = 0; i < 4; ++i) {
    d_rotation[i] = (dq[i] - along * terms.quaternion[i]) * terms.inverse_norm;
  }
}

}  // namespace freegs::splat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // FREEGS_SPLAT_PROJECTION_EWA_PROJECTION_INL_H_
