// SPDX-License-Identifier: BSD-3-Clause

#include "splat/adam_simd.h"

#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/adam_simd.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace freegs::splat::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class D>
HWY_INLINE void UpdateAt(D d,
                         const AdamCoefficients& c,
                         const float* gradient,
                         float* first_moment,
                         float* second_moment,
                         float* parameter) {
  const auto g = hn::LoadU(d, gradient);
  auto m = hn::LoadU(d, first_moment);
  auto v = hn::LoadU(d, second_moment);
  m = hn::MulAdd(hn::Set(d, c.one_minus_beta1), hn::Sub(g, m), m);
  v = hn::MulAdd(hn::Mul(hn::Set(d, c.one_minus_beta2), g),
                 g,
                 hn::Mul(hn::Set(d, c.beta2), v));
  const auto root = hn::MulAdd(
      hn::Sqrt(v), hn::Set(d, c.root_correction), hn::Set(d, c.epsilon));
  const auto step = hn::Div(hn::Mul(hn::Set(d, c.step_size), m), root);
  hn::StoreU(m, d, first_moment);
  hn::StoreU(v, d, second_moment);
  hn::StoreU(hn::Sub(hn::LoadU(d, parameter), step), d, parameter);
}

void UpdateArray(const AdamCoefficients& coefficients,
                 std::span<const uint32_t> touched,
                 size_t stride,
                 const float* gradients,
                 float* first_moments,
                 float* second_moments,
                 float* parameters) {
  const hn::ScalableTag<float> wide;
  const hn::CappedTag<float, 1> one;
  const size_t lanes = hn::Lanes(wide);
  for (size_t k = 0; k < touched.size();) {
    const size_t run_begin = touched[k];
    size_t run_end = run_begin;
    while (k < touched.size() && touched[k] == run_end) {
      ++k;
      ++run_end;
    }
    size_t i = run_begin * stride;
    const size_t end = run_end * stride;
    for (; i + lanes <= end; i += lanes) {
      UpdateAt(wide,
               coefficients,
               gradients + i,
               first_moments + i,
               second_moments + i,
               parameters + i);
    }
    for (; i < end; ++i) {
      UpdateAt(one,
               coefficients,
               gradients + i,
               first_moments + i,
               second_moments + i,
               parameters + i);
    }
  }
}

}  // namespace freegs::splat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace freegs::splat {

HWY_EXPORT(UpdateArray);

void UpdateAdamArray(const AdamCoefficients& coefficients,
                     std::span<const uint32_t> touched,
                     int stride,
                     const float* gradients,
                     float* first_moments,
                     float* second_moments,
                     float* parameters) {
  if (stride == 0) return;
  HWY_DYNAMIC_DISPATCH(UpdateArray)
  (coefficients,
   touched,
   static_cast<size_t>(stride),
   gradients,
   first_moments,
   second_moments,
   parameters);
}

}  // namespace freegs::splat
#endif  // HWY_ONCE
