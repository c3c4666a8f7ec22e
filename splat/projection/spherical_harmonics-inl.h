// SPDX-License-Identifier: BSD-3-Clause
// Real spherical harmonics to degree 3, in the sign convention of 3DGS files.

// Compiled anew for each instruction set: see hwy/highway.h on -inl.h files.
#if defined(FREEGS_SPLAT_PROJECTION_SPHERICAL_HARMONICS_INL_H_) == \
    defined(HWY_TARGET_TOGGLE)
#ifdef FREEGS_SPLAT_PROJECTION_SPHERICAL_HARMONICS_INL_H_
#undef FREEGS_SPLAT_PROJECTION_SPHERICAL_HARMONICS_INL_H_
#else
#define FREEGS_SPLAT_PROJECTION_SPHERICAL_HARMONICS_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace freegs::splat::HWY_NAMESPACE {

// The basis functions of degree 1..degree at the unit direction (x, y, z), in
// the order of sh_rest: basis[k - 1] is coefficient k. Degree 0 is kShC0.
template <typename T>
void EvaluateShBasis(int degree, T x, T y, T z, T* basis) {
  if (degree < 1) return;
  constexpr double kC1 = 0.4886025119029199;
  basis[0] = T(-kC1) * y;
  basis[1] = T(kC1) * z;
  basis[2] = T(-kC1) * x;
  if (degree < 2) return;
  const T xx = x * x, yy = y * y, zz = z * z;
  constexpr double kC2 = 1.0925484305920792;
  constexpr double kC20 = 0.31539156525252005;
  basis[3] = T(kC2) * x * y;
  basis[4] = T(-kC2) * y * z;
  basis[5] = T(kC20) * (T(2) * zz - xx - yy);
  basis[6] = T(-kC2) * x * z;
  basis[7] = T(kC2 / 2) * (xx - yy);
  if (degree < 3) return;
  constexpr double kC33 = 0.5900435899266435;
  constexpr double kC32 = 2.890611442640554;
  constexpr double kC31 = 0.4570457994644658;
  constexpr double kC30 = 0.3731763325901154;
  basis[8] = T(-kC33) * y * (T(3) * xx - yy);
  basis[9] = T(kC32) * x * y * z;
  basis[10] = T(-kC31) * y * (T(4) * zz - xx - yy);
  basis[11] = T(kC30) * z * (T(2) * zz - T(3) * xx - T(3) * yy);
  basis[12] = T(-kC31) * x * (T(4) * zz - xx - yy);
  basis[13] = T(kC32 / 2) * z * (xx - yy);
  basis[14] = T(-kC33) * x * (xx - T(3) * yy);
}

// Adds to (dx, dy, dz) the derivative of sum_k weight[k - 1] * basis[k - 1]
// with respect to (x, y, z), the three taken as independent.
template <typename T>
void BackwardShBasis(
    int degree, T x, T y, T z, const T* weight, T* dx, T* dy, T* dz) {
  if (degree < 1) return;
  constexpr double kC1 = 0.4886025119029199;
  *dx += T(-kC1) * weight[2];
  *dy += T(-kC1) * weight[0];
  *dz += T(kC1) * weight[1];
  if (degree < 2) return;
  constexpr double kC2 = 1.0925484305920792;
  constexpr double kC20 = 0.31539156525252005;
  *dx += T(kC2) * (y * weight[3] - z * weight[6] + x * weight[7]) -
         T(2 * kC20) * x * weight[5];
  *dy += T(kC2) * (x * weight[3] - z * weight[4] - y * weight[7]) -
         T(2 * kC20) * y * weight[5];
  *dz +=
      T(kC2) * (-y * weight[4] - x * weight[6]) + T(4 * kC20) * z * weight[5];
  if (degree < 3) return;
  constexpr double kC33 = 0.5900435899266435;
  constexpr double kC32 = 2.890611442640554;
  constexpr double kC31 = 0.4570457994644658;
  constexpr double kC30 = 0.3731763325901154;
  const T xx = x * x, yy = y * y, zz = z * z;
  *dx += T(-6 * kC33) * x * y * weight[8] + T(kC32) * y * z * weight[9] +
         T(2 * kC31) * x * y * weight[10] - T(6 * kC30) * x * z * weight[11] -
         T(kC31) * (T(4) * zz - T(3) * xx - yy) * weight[12] +
         T(kC32) * x * z * weight[13] - T(3 * kC33) * (xx - yy) * weight[14];
  *dy += T(-3 * kC33) * (xx - yy) * weight[8] + T(kC32) * x * z * weight[9] -
         T(kC31) * (T(4) * zz - xx - T(3) * yy) * weight[10] -
         T(6 * kC30) * y * z * weight[11] + T(2 * kC31) * x * y * weight[12] -
         T(kC32) * y * z * weight[13] + T(6 * kC33) * x * y * weight[14];
  *dz += T(kC32) * x * y * weight[9] - T(8 * kC31) * y * z * weight[10] +
         T(3 * kC30) * (T(2) * zz - xx - yy) * weight[11] -
         T(8 * kC31) * x * z * weight[12] +
         T(kC32 / 2) * (xx - yy) * weight[13];
}

}  // namespace freegs::splat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // FREEGS_SPLAT_PROJECTION_SPHERICAL_HARMONICS_INL_H_
