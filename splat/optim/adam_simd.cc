// SPDX-License-Identifier: BSD-3-Clause

#include "splat/optim/adam_simd.h"

#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/optim/adam_simd.cc"
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
                 GradientRows rows,
                 size_t stride,
                 const float* gradients,
                 float* first_moments,
                 float* second_moments,
                 float* parameters) {
  size_t i = 0;
  size_t end = 0;
  const float* gradient = nullptr;  // That of the run's first parameter.
  // Updates whole vectors of this width from i on.
  const auto update = [&](auto d) HWY_ATTR {
    const size_t lanes = hn::Lanes(d);
    for (; i + lanes <= end; i += lanes, gradient += lanes) {
      UpdateAt(d,
               coefficients,
               gradient,
               first_moments + i,
               second_moments + i,
               parameters + i);
    }
  };
  for (size_t k = 0; k < touched.size();) {
    const size_t run_begin = touched[k];
    gradient =
        gradients + stride * (rows == GradientRows::kByIndex ? run_begin : k);
    size_t run_end = run_begin;
    while (k < touched.size() && touched[k] == run_end) {
      ++k;
      ++run_end;
    }
    i = run_begin * stride;
    end = run_end * stride;
    // Runs of consecutive indices are short when a view shows few Gaussians, so
    // the rest of a run must be fast too. Masked stores cannot do it: they may
    // write to neighbouring floats, which belong to another thread.
    update(hn::ScalableTag<float>());
    update(hn::CappedTag<float, 4>());
    update(hn::CappedTag<float, 1>());
  }
}

}  // namespace freegs::splat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace freegs::splat {

HWY_EXPORT(UpdateArray);

void UpdateAdamArray(const AdamCoefficients& coefficients,
                     std::span<const uint32_t> touched,
                     GradientRows rows,
                     int stride,
                     const float* gradients,
                     float* first_moments,
                     float* second_moments,
                     float* parameters) {
  if (stride == 0) return;
  HWY_DYNAMIC_DISPATCH(UpdateArray)
  (coefficients,
   touched,
   rows,
   static_cast<size_t>(stride),
   gradients,
   first_moments,
   second_moments,
   parameters);
}

}  // namespace freegs::splat
#endif  // HWY_ONCE
