// SPDX-License-Identifier: BSD-3-Clause

#include "core/kd_tree_simd.h"

#include <cstddef>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/kd_tree_simd.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace freegs::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kKdBlockSize>;
using V = hn::Vec<D>;

// Squared distances of the entries from j on; two sums hide the latency.
struct Points {
  static HWY_INLINE V
  Distance2(D d, const float* block, int dim, const float* query, size_t j) {
    V even = hn::Zero(d);
    V odd = hn::Zero(d);
    int k = 0;
    for (; k + 1 < dim; k += 2) {
      const float* row = block + static_cast<size_t>(k) * kKdBlockSize + j;
      const V a = hn::Sub(hn::LoadU(d, row), hn::Set(d, query[k]));
      const V b =
          hn::Sub(hn::LoadU(d, row + kKdBlockSize), hn::Set(d, query[k + 1]));
      even = hn::MulAdd(a, a, even);
      odd = hn::MulAdd(b, b, odd);
    }
    if (k < dim) {
      const float* row = block + static_cast<size_t>(k) * kKdBlockSize + j;
      const V a = hn::Sub(hn::LoadU(d, row), hn::Set(d, query[k]));
      even = hn::MulAdd(a, a, even);
    }
    return hn::Add(even, odd);
  }
};

struct Boxes {
  static HWY_INLINE V Outside(D d, const float* row, float query) {
    const V center = hn::Set(d, query);
    const V below = hn::Sub(hn::LoadU(d, row), center);
    const V above = hn::Sub(center, hn::LoadU(d, row + kKdBlockSize));
    return hn::Max(hn::Max(below, above), hn::Zero(d));
  }
  static HWY_INLINE V
  Distance2(D d, const float* block, int dim, const float* query, size_t j) {
    V even = hn::Zero(d);
    V odd = hn::Zero(d);
    constexpr size_t kRow = 2 * kKdBlockSize;
    int k = 0;
    for (; k + 1 < dim; k += 2) {
      const float* row = block + k * kRow + j;
      const V a = Outside(d, row, query[k]);
      const V b = Outside(d, row + kRow, query[k + 1]);
      even = hn::MulAdd(a, a, even);
      odd = hn::MulAdd(b, b, odd);
    }
    if (k < dim) {
      const V a = Outside(d, block + k * kRow + j, query[k]);
      even = hn::MulAdd(a, a, even);
    }
    return hn::Add(even, odd);
  }
};

HWY_INLINE V Lower(D d, V distance2, int dim) {
  return hn::Max(
      hn::MulSub(
          distance2, hn::Set(d, KdBoundFactor(dim)), hn::Set(d, kKdSlack)),
      hn::Zero(d));
}

template <class M>
HWY_INLINE uint32_t Bits(D d, M mask) {
  uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  return static_cast<uint32_t>(bytes[0]) | static_cast<uint32_t>(bytes[1]) << 8;
}

template <class Entries>
HWY_INLINE uint32_t Bounds(const float* block,
                           int dim,
                           const float* query,
                           float limit,
                           float* bounds) {
  const D d;
  uint32_t within = 0;
  for (size_t j = 0; j < kKdBlockSize; j += hn::Lanes(d)) {
    const V bound = Lower(d, Entries::Distance2(d, block, dim, query, j), dim);
    hn::StoreU(bound, d, bounds + j);
    within |= Bits(d, hn::Le(bound, hn::Set(d, limit))) << j;
  }
  return within;
}

template <class Entries>
HWY_INLINE KdBlockBounds FilteredBounds(const float* block,
                                        int dim,
                                        const float* query,
                                        const KdBlockFilter& filter,
                                        float limit,
                                        float* bounds) {
  const D d;
  const hn::RebindToUnsigned<D> du;
  const V infinity = hn::Set(d, std::numeric_limits<float>::infinity());
  KdBlockBounds result;
  V beyond = infinity;
  for (size_t j = 0; j < kKdBlockSize; j += hn::Lanes(d)) {
    const V distance =
        Lower(d, Entries::Distance2(d, block, dim, query, j), dim);
    const auto own = hn::RebindMask(
        d,
        hn::Eq(hn::LoadU(du, filter.components + j), hn::Set(du, filter.own)));
    const V bound = hn::IfThenElse(
        own, infinity, hn::Max(distance, hn::LoadU(d, filter.floors + j)));
    hn::StoreU(bound, d, bounds + j);
    const auto within = hn::Le(bound, hn::Set(d, limit));
    result.within |= Bits(d, within) << j;
    beyond = hn::Min(beyond, hn::IfThenElse(within, infinity, bound));
  }
  result.least_beyond = hn::GetLane(hn::MinOfLanes(d, beyond));
  return result;
}

uint32_t PointBounds(const float* block,
                     int dim,
                     const float* query,
                     float limit,
                     float* bounds) {
  return Bounds<Points>(block, dim, query, limit, bounds);
}

uint32_t BoxBounds(const float* block,
                   int dim,
                   const float* query,
                   float limit,
                   float* bounds) {
  return Bounds<Boxes>(block, dim, query, limit, bounds);
}

KdBlockBounds FilteredPointBounds(const float* block,
                                  int dim,
                                  const float* query,
                                  const KdBlockFilter& filter,
                                  float limit,
                                  float* bounds) {
  return FilteredBounds<Points>(block, dim, query, filter, limit, bounds);
}

KdBlockBounds FilteredBoxBounds(const float* block,
                                int dim,
                                const float* query,
                                const KdBlockFilter& filter,
                                float limit,
                                float* bounds) {
  return FilteredBounds<Boxes>(block, dim, query, filter, limit, bounds);
}

}  // namespace freegs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace freegs {

HWY_EXPORT(PointBounds);
HWY_EXPORT(BoxBounds);
HWY_EXPORT(FilteredPointBounds);
HWY_EXPORT(FilteredBoxBounds);

uint32_t KdPointBounds(const float* block,
                       int dim,
                       const float* query,
                       float limit,
                       float bounds[kKdBlockSize]) {
  return HWY_DYNAMIC_DISPATCH(PointBounds)(block, dim, query, limit, bounds);
}

uint32_t KdBoxBounds(const float* block,
                     int dim,
                     const float* query,
                     float limit,
                     float bounds[kKdBlockSize]) {
  return HWY_DYNAMIC_DISPATCH(BoxBounds)(block, dim, query, limit, bounds);
}

KdBlockBounds KdPointBounds(const float* block,
                            int dim,
                            const float* query,
                            const KdBlockFilter& filter,
                            float limit,
                            float bounds[kKdBlockSize]) {
  return HWY_DYNAMIC_DISPATCH(FilteredPointBounds)(
      block, dim, query, filter, limit, bounds);
}

KdBlockBounds KdBoxBounds(const float* block,
                          int dim,
                          const float* query,
                          const KdBlockFilter& filter,
                          float limit,
                          float bounds[kKdBlockSize]) {
  return HWY_DYNAMIC_DISPATCH(FilteredBoxBounds)(
      block, dim, query, filter, limit, bounds);
}

}  // namespace freegs
#endif  // HWY_ONCE
