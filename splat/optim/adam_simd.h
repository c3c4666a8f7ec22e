// SPDX-License-Identifier: BSD-3-Clause
// The Adam update of one array of parameters, vectorised.

#ifndef FREEGS_SPLAT_OPTIM_ADAM_SIMD_H_
#define FREEGS_SPLAT_OPTIM_ADAM_SIMD_H_

#include <cstdint>
#include <span>

namespace freegs::splat {

// The constants of one step. With g the gradient, m and v the moments it does
//   m += (1 - beta1) (g - m),  v = beta2 v + (1 - beta2) g^2,
//   parameter -= step_size m / (sqrt(v) root_correction + epsilon)
// with step_size = rate / (1 - beta1^t), root_correction = 1/sqrt(1 - beta2^t).
struct AdamCoefficients {
  float one_minus_beta1;
  float beta2;
  float one_minus_beta2;
  float step_size;
  float root_correction;
  float epsilon;
};

// Whether the gradient of Gaussian touched[j] is in row touched[j] (kByIndex)
// or in row j (kByPlace).
enum class GradientRows { kByIndex, kByPlace };

// Updates the Gaussians in `touched` (ascending). The arrays are N x stride,
// but `gradients` is touched.size() x stride for kByPlace.
void UpdateAdamArray(const AdamCoefficients& coefficients,
                     std::span<const uint32_t> touched,
                     GradientRows rows,
                     int stride,
                     const float* gradients,
                     float* first_moments,
                     float* second_moments,
                     float* parameters);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_OPTIM_ADAM_SIMD_H_
