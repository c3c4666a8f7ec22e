// SPDX-License-Identifier: BSD-3-Clause

#include "splat/weights/blending_products_simd.h"

#include <cstdint>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/weights/blending_products_simd.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace freegs::splat::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// The pointers of W are copied to local variables: the compiler must assume
// that a store of a vector changes anything in memory.
struct RowPointers {
  explicit RowPointers(const WeightMatrix& w)
      : pixel_begin(w.pixel_begin.data()),
        gaussians(w.gaussians.data()),
        weights(w.weights.data()) {}

  const uint32_t* pixel_begin;
  const uint32_t* gaussians;
  const float* weights;
};

// One vector of channels of the rows [first, last). features and pixels point
// to the first of these channels.
template <class D>
HWY_INLINE void MultiplyOne(D d,
                            RowPointers w,
                            size_t first,
                            size_t last,
                            const float* HWY_RESTRICT features,
                            size_t channels,
                            float* HWY_RESTRICT pixels) {
  for (size_t p = first; p < last; ++p, pixels += channels) {
    auto sum = hn::Zero(d);
    const uint32_t end = w.pixel_begin[p + 1];
    for (uint32_t k = w.pixel_begin[p]; k < end; ++k) {
      const float* feature = features + w.gaussians[k] * channels;
      sum = hn::MulAdd(hn::Set(d, w.weights[k]), hn::LoadU(d, feature), sum);
    }
    hn::StoreU(sum, d, pixels);
  }
}

// Does what MultiplyOne does, for four vectors: the row of W is read once for
// all of them, and their sums do not wait for one another.
template <class D>
HWY_INLINE void MultiplyFour(D d,
                             RowPointers w,
                             size_t first,
                             size_t last,
                             const float* HWY_RESTRICT features,
                             size_t channels,
                             float* HWY_RESTRICT pixels) {
  const size_t lanes = hn::Lanes(d);
  for (size_t p = first; p < last; ++p, pixels += channels) {
    auto sum0 = hn::Zero(d);
    auto sum1 = hn::Zero(d);
    auto sum2 = hn::Zero(d);
    auto sum3 = hn::Zero(d);
    const uint32_t end = w.pixel_begin[p + 1];
    for (uint32_t k = w.pixel_begin[p]; k < end; ++k) {
      const float* feature = features + w.gaussians[k] * channels;
      const auto weight = hn::Set(d, w.weights[k]);
      sum0 = hn::MulAdd(weight, hn::LoadU(d, feature), sum0);
      sum1 = hn::MulAdd(weight, hn::LoadU(d, feature + lanes), sum1);
      sum2 = hn::MulAdd(weight, hn::LoadU(d, feature + 2 * lanes), sum2);
      sum3 = hn::MulAdd(weight, hn::LoadU(d, feature + 3 * lanes), sum3);
    }
    hn::StoreU(sum0, d, pixels);
    hn::StoreU(sum1, d, pixels + lanes);
    hn::StoreU(sum2, d, pixels + 2 * lanes);
    hn::StoreU(sum3, d, pixels + 3 * lanes);
  }
}

// Does what MultiplyOne does, for the transposed product. A row lists a
// Gaussian only once, so no vector is read before it has been written.
template <class D>
HWY_INLINE void AddTransposedOne(D d,
                                 RowPointers w,
                                 size_t first,
                                 size_t last,
                                 const float* HWY_RESTRICT pixels,
                                 size_t pixel_stride,
                                 float* HWY_RESTRICT sums,
                                 size_t sum_stride) {
  for (size_t p = first; p < last; ++p, pixels += pixel_stride) {
    const auto pixel = hn::LoadU(d, pixels);
    const uint32_t end = w.pixel_begin[p + 1];
    for (uint32_t k = w.pixel_begin[p]; k < end; ++k) {
      float* sum = sums + w.gaussians[k] * sum_stride;
      const auto weight = hn::Set(d, w.weights[k]);
      hn::StoreU(hn::MulAdd(weight, pixel, hn::LoadU(d, sum)), d, sum);
    }
  }
}

template <class D>
HWY_INLINE void AddTransposedTwo(D d,
                                 RowPointers w,
                                 size_t first,
                                 size_t last,
                                 const float* HWY_RESTRICT pixels,
                                 size_t pixel_stride,
                                 float* HWY_RESTRICT sums,
                                 size_t sum_stride) {
  const size_t lanes = hn::Lanes(d);
  for (size_t p = first; p < last; ++p, pixels += pixel_stride) {
    const auto pixel0 = hn::LoadU(d, pixels);
    const auto pixel1 = hn::LoadU(d, pixels + lanes);
    const uint32_t end = w.pixel_begin[p + 1];
    for (uint32_t k = w.pixel_begin[p]; k < end; ++k) {
      float* sum = sums + w.gaussians[k] * sum_stride;
      const auto weight = hn::Set(d, w.weights[k]);
      const auto sum0 = hn::MulAdd(weight, pixel0, hn::LoadU(d, sum));
      const auto sum1 = hn::MulAdd(weight, pixel1, hn::LoadU(d, sum + lanes));
      hn::StoreU(sum0, d, sum);
      hn::StoreU(sum1, d, sum + lanes);
    }
  }
}

void MultiplyChannels(const WeightMatrix& weights,
                      size_t first,
                      size_t last,
                      const float* features,
                      size_t channels,
                      float* pixels) {
  const RowPointers w(weights);
  const hn::ScalableTag<float> full;
  const size_t four = 4 * hn::Lanes(full);
  size_t c = 0;
  for (; c + four <= channels; c += four) {
    MultiplyFour(full, w, first, last, features + c, channels, pixels + c);
  }
  const auto rest = [&](auto d) HWY_ATTR {
    for (; c + hn::Lanes(d) <= channels; c += hn::Lanes(d)) {
      MultiplyOne(d, w, first, last, features + c, channels, pixels + c);
    }
  };
  rest(full);
  rest(hn::CappedTag<float, 4>());
  rest(hn::CappedTag<float, 1>());
}

void AddTransposedChannels(const WeightMatrix& weights,
                           size_t first,
                           size_t last,
                           const float* pixels,
                           size_t pixel_stride,
                           size_t channels,
                           float* sums,
                           size_t sum_stride) {
  const RowPointers w(weights);
  const hn::ScalableTag<float> full;
  const size_t two = 2 * hn::Lanes(full);
  size_t c = 0;
  for (; c + two <= channels; c += two) {
    AddTransposedTwo(
        full, w, first, last, pixels + c, pixel_stride, sums + c, sum_stride);
  }
  // Only whole vectors are stored: masked stores may write to the channels of
  // another thread.
  const auto rest = [&](auto d) HWY_ATTR {
    for (; c + hn::Lanes(d) <= channels; c += hn::Lanes(d)) {
      AddTransposedOne(
          d, w, first, last, pixels + c, pixel_stride, sums + c, sum_stride);
    }
  };
  rest(full);
  rest(hn::CappedTag<float, 4>());
  rest(hn::CappedTag<float, 1>());
}

}  // namespace freegs::splat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace freegs::splat {

HWY_EXPORT(MultiplyChannels);
HWY_EXPORT(AddTransposedChannels);

void MultiplyRows(const WeightMatrix& weights,
                  size_t first,
                  size_t last,
                  const float* features,
                  size_t channels,
                  float* pixels) {
  HWY_DYNAMIC_DISPATCH(MultiplyChannels)
  (weights, first, last, features, channels, pixels);
}

void AddTransposedRows(const WeightMatrix& weights,
                       size_t first,
                       size_t last,
                       const float* pixels,
                       size_t pixel_stride,
                       size_t channels,
                       float* sums,
                       size_t sum_stride) {
  HWY_DYNAMIC_DISPATCH(AddTransposedChannels)
  (weights, first, last, pixels, pixel_stride, channels, sums, sum_stride);
}

}  // namespace freegs::splat
#endif  // HWY_ONCE
