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
  T* n = terms->cross;
  n[0] = a[1] * a[5] - a[2] * a[4];
  n[1] = a[2] * a[3] - a[0] * a[5];
  n[2] = a[0] * a[4] - a[1] * a[3];
  const T determinant = n[0] * n[0] + n[1] * n[1] + n[2] * n[2] +
                        camera.dilation * (cov[0] + cov[2] - camera.dilation);
  terms->determinant = determinant;
  projected->conic_xx = cov[2] / determinant;
  projected->precision_y = T(1) / cov[2];
  projected->shear = -cov[1] * projected->precision_y;
  // Comparisons that fail for NaN.
  return And(And(t[2] > camera.near_plane, squared_norm > T(1e-20)),
             And(determinant > T(1e-12), T(1e30) > determinant));
}

// The square of what the 2D filter of Mip-Splatting (Yu et al. 2024) takes off
// the opacity, det(A A^T) / det(Sigma'), for which the dilation is made up for.
// Below kMinFilter the filter is that of kMinFilter, and has no derivative.
constexpr float kMinFilter = 2.5e-5f;
template <typename T>
T SquaredOpacityFilter(const ProjectionTerms<T>& terms) {
  const T* n = terms.cross;
  return (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / terms.determinant;
}

// The natural logarithm of what the dilation takes off the opacity of an
// antialiased Gaussian, from the results of ProjectGaussian: log(0.005) to 0.
template <typename T>
T LogOpacityFilter(const ProjectionTerms<T>& terms) {
  using std::log;
  const T square = SquaredOpacityFilter(terms);
  const T least(kMinFilter);
  return T(0.5) * log(Select(square > least, square, least));
}

// The part of the derivative that goes through the covariance Sigma'. Writes
// dL/dA, adds to dL/dlog_scale, and overwrites dL/drotation.
template <typename T>
void BackwardCovariance(const ProjectionCamera<T>& camera,
                        const ProjectedGaussian<T>& projected,
                        const ProjectionTerms<T>& terms,
                        const ProjectedGradient<T>& gradient,
                        T da[6],
                        T d_log_scale[3],
                        T d_rotation[4]) {
  const T* a = terms.half;
  const T* n = terms.cross;
  const T* s = terms.scale;

  // Sigma'^-1 = F^T D F with F = [1 shear; 0 1] and D = diag(conic_xx,
  // precision_y), and F d = (e, dy). With the rows a0 and a1 of A and
  // n = a0 x a1 the rows of B = D F A are (dilation a0 + a1 x n) / det and
  // precision_y a1, in which nothing cancels. In a0 + shear a1 all digits do
  // where the image of a Gaussian is a few hundred times as long as wide.
  //
  // ln(alpha) is that of Sigma' at the pixels, whose part of dL/dSigma' is
  // F^T D M D F / 2 with gradient.moments as the symmetric matrix M, and that
  // of the filter, ln(det(A A^T) / det(Sigma')) / 2. The inverses of A A^T and
  // Sigma' nearly cancel, but their difference is the product of both times the
  // dilation. With the rows a1 x n / |n|^2 and -a0 x n / |n|^2 of
  // (A A^T)^-1 A this is F^T D C for the matrix C below. Together
  // dL/dA = F^T D (M B + C).
  const T inverse_determinant = T(1) / terms.determinant;
  const T squared_cross = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
  const T filter = Select(SquaredOpacityFilter(terms) > T(kMinFilter),
                          gradient.log_filter * camera.dilation / squared_cross,
                          T(0));
  const T* m = gradient.moments;
  T b[6], mb_c[6];
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const T a0_n = a[j] * n[k] - a[k] * n[j];
    const T a1_n = a[3 + j] * n[k] - a[3 + k] * n[j];
    b[i] = (camera.dilation * a[i] + a1_n) * inverse_determinant;
    b[3 + i] = projected.precision_y * a[3 + i];
    mb_c[i] = m[0] * b[i] + m[1] * b[3 + i] +
              filter * (a1_n - projected.shear * a0_n);
    mb_c[3 + i] = m[1] * b[i] + m[2] * b[3 + i] - filter * a0_n;
    const T xx = projected.conic_xx * mb_c[i];
    da[i] = xx;
    da[3 + i] = projected.shear * xx + projected.precision_y * mb_c[3 + i];
  }

  // A = K R S with K = J W. The symmetric matrix E = A^T dL/dA is
  // B^T (M B + C). Its diagonal is dL/dlog_scale, and
  // R^T dL/dR = S^-1 E S. A small turn by the vector t in the Gaussian's own
  // axes changes R by R [t]_x, so the torque is dL/dt.
  T inverse_scale[3], torque[3];
  for (int i = 0; i < 3; ++i) {
    // Where a scale is 0 as a float, E is 0 as well.
    inverse_scale[i] = T(1) / (s[i] + T(1e-30));
  }
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    d_log_scale[i] += b[i] * mb_c[i] + b[3 + i] * mb_c[3 + i];
    const T e_kj = b[k] * mb_c[j] + b[3 + k] * mb_c[3 + j];
    torque[i] = e_kj * (s[j] * inverse_scale[k] - s[k] * inverse_scale[j]);
  }

  // The turn changes the unit quaternion q by its product with (0, t) / 2. So
  // the derivative is twice the product with (0, torque). It has no part along
  // q, which the normalisation would take away.
  const T* q = terms.quaternion;
  const T turn = T(2) * terms.inverse_norm;
  d_rotation[0] =
      -turn * (q[1] * torque[0] + q[2] * torque[1] + q[3] * torque[2]);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    d_rotation[1 + i] =
        turn * (q[0] * torque[i] + q[1 + j] * torque[k] - q[1 + k] * torque[j]);
  }
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
  T da[6];
  BackwardCovariance(
      camera, projected, terms, gradient, da, d_log_scale, d_rotation);

  const T* w = camera.rotation;
  const T* s = terms.scale;
  // dL/dK = dL/dA (R S)^T.
  const T* r = terms.rotation;
  T dk[6];
  for (int row = 0; row < 2; ++row) {
    for (int i = 0; i < 3; ++i) {
      dk[3 * row + i] = da[3 * row] * r[3 * i] * s[0] +
                        da[3 * row + 1] * r[3 * i + 1] * s[1] +
                        da[3 * row + 2] * r[3 * i + 2] * s[2];
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
}

}  // namespace freegs::splat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // FREEGS_SPLAT_PROJECTION_EWA_PROJECTION_INL_H_
