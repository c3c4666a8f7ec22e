// SPDX-License-Identifier: BSD-3-Clause
// Exhaustive SIFT matching as a blocked matrix product.
//
// Values are multiplied as 16-bit integers, two at a time. All sums are of
// integers below 2^24, which floats hold exactly: the result is the same for
// every vector width.

#include "sfm/matching/descriptor_matching.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <hwy/aligned_allocator.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sfm/matching/descriptor_matching.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef FREEGS_SFM_DESCRIPTOR_MATCHING_CC_
#define FREEGS_SFM_DESCRIPTOR_MATCHING_CC_

namespace freegs::sfm {

// The largest two products of a descriptor with those of the other photo.
struct BestTwo {
  float best = -1;
  float second = -1;
  uint32_t index = 0;
};

// Rows of `a` are handled in groups of this many; counts are padded to it.
inline constexpr size_t kRows = 4;

// A descriptor as integers of 32 bits, each of which holds two of its values.
inline constexpr size_t kPairs = kSiftDimensions / 2;

// Rows of `a` (of 256 bytes) that are worked on at a time.
inline constexpr size_t kChunk = 256;

// Running best two of a list of descriptors, with the index of the best.
struct Running {
  explicit Running(size_t count)
      : best(hwy::AllocateAligned<float>(count)),
        second(hwy::AllocateAligned<float>(count)),
        index(hwy::AllocateAligned<float>(count)) {
    std::fill_n(best.get(), count, -1.0f);
    std::fill_n(second.get(), count, -1.0f);
    std::fill_n(index.get(), count, 0.0f);
  }
  hwy::AlignedFreeUniquePtr<float[]> best;
  hwy::AlignedFreeUniquePtr<float[]> second;
  hwy::AlignedFreeUniquePtr<float[]> index;
};

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_DESCRIPTOR_MATCHING_CC_

HWY_BEFORE_NAMESPACE();
namespace freegs::sfm::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Enters a vector of products, at indices `index`, into running best values.
template <typename V>
HWY_INLINE void Enter(V product, V index, V& best, V& second, V& best_index) {
  const auto better = hn::Gt(product, best);
  second = hn::Max(second, hn::Min(product, best));
  best = hn::Max(best, product);
  best_index = hn::IfThenElse(better, index, best_index);
}

// The best two over the lanes. Equal bests in two lanes make the second equal
// to the best, which no ratio test passes; so their order does not matter.
BestTwo OverLanes(const float* best,
                  const float* second,
                  const float* index,
                  size_t lanes) {
  BestTwo result;
  for (size_t i = 0; i < lanes; ++i) {
    if (best[i] > result.best) {
      result.second = std::max(result.best, second[i]);
      result.best = best[i];
      result.index = static_cast<uint32_t>(index[i]);
    } else {
      result.second = std::max(result.second, best[i]);
    }
  }
  return result;
}

// Copies num_b descriptors into blocks of `block` descriptors, of which there
// are padded_b with the zero ones at the end. Each block holds the first pair
// of all its descriptors, then the second, and so on.
hwy::AlignedFreeUniquePtr<int32_t[]> PackBlocks(const int32_t* b,
                                                size_t num_b,
                                                size_t padded_b,
                                                size_t block) {
  auto packed = hwy::AllocateAligned<int32_t>(padded_b * kPairs);
  for (size_t j = 0; j < padded_b; ++j) {
    int32_t* const to = packed.get() + j / block * block * kPairs + j % block;
    for (size_t k = 0; k < kPairs; ++k) {
      to[k * block] = j < num_b ? b[j * kPairs + k] : 0;
    }
  }
  return packed;
}

// A sum of products of pairs, of each lane.
#if HWY_TARGET == HWY_SCALAR
// One lane of 32 bits has no two lanes of 16.
template <typename D, typename V = hn::Vec<D>>
struct PairSum {
  V sum;

  static HWY_INLINE PairSum Zero() { return {hn::Zero(D())}; }
  HWY_INLINE void Add(V a, V b) {
    const V low = hn::Set(D(), 0xffff);
    const V first = hn::Mul(hn::And(a, low), hn::And(b, low));
    const V second = hn::Mul(hn::ShiftRight<16>(a), hn::ShiftRight<16>(b));
    sum = hn::Add(sum, hn::Add(first, second));
  }
  HWY_INLINE auto Sum() const {
    return hn::ConvertTo(hn::RebindToFloat<D>(), sum);
  }
};
#else
template <typename D, typename V = hn::Vec<D>>
struct PairSum {
  // On some processors the parts belong to other lanes until they are added.
  V part0;
  V part1;

  static HWY_INLINE PairSum Zero() { return {hn::Zero(D()), hn::Zero(D())}; }
  HWY_INLINE void Add(V a, V b) {
    const hn::RepartitionToNarrow<D> narrow;
    part0 = hn::ReorderWidenMulAccumulate(
        D(), hn::BitCast(narrow, a), hn::BitCast(narrow, b), part0, part1);
  }
  HWY_INLINE auto Sum() const {
    return hn::ConvertTo(hn::RebindToFloat<D>(),
                         hn::RearrangeToOddPlusEven(part0, part1));
  }
};
#endif

// Multiplies all descriptors of two photos. `a` is a num_a x kPairs matrix, row
// by row, where num_a is a multiple of kRows and rows from valid_a on are zero.
// `b` is a num_b x kPairs matrix. `rows` receives, for each of the first
// valid_a rows of a, its best two products with rows of b; `columns` receives,
// for each row of b, its best two products with those rows of a.
void BestProducts(const int32_t* HWY_RESTRICT a,
                  size_t num_a,
                  size_t valid_a,
                  const int32_t* HWY_RESTRICT b,
                  size_t num_b,
                  BestTwo* rows,
                  BestTwo* columns) {
  const hn::ScalableTag<float> d;
  const hn::RebindToSigned<decltype(d)> di;
  using V = hn::Vec<decltype(d)>;
  using VI = hn::Vec<decltype(di)>;
  using Sum = PairSum<decltype(di)>;
  const size_t lanes = hn::Lanes(d);
  const size_t block = 2 * lanes;
  const size_t padded_b = (num_b + block - 1) / block * block;
  const V none = hn::Set(d, -1.0f);

  const auto packed = PackBlocks(b, num_b, padded_b, block);
  // Running bests: of each row of a one vector, of each of b one lane.
  Running row(num_a * lanes);
  Running column(padded_b);

  // A chunk of a stays in the cache while all of b passes by.
  for (size_t chunk = 0; chunk < num_a; chunk += kChunk) {
    const size_t chunk_end = std::min(chunk + kChunk, num_a);
    for (size_t first = 0; first < num_b; first += block) {
      const int32_t* const block_b = packed.get() + first * kPairs;
      // Lanes beyond the end must not win: their products are made -1.
      const V index0 = hn::Iota(d, static_cast<float>(first));
      const V index1 = hn::Iota(d, static_cast<float>(first + lanes));
      const V end = hn::Set(d, static_cast<float>(num_b));
      const size_t second_half = first + lanes;
      V best0 = hn::Load(d, column.best.get() + first);
      V runner0 = hn::Load(d, column.second.get() + first);
      V at0 = hn::Load(d, column.index.get() + first);
      V best1 = hn::Load(d, column.best.get() + second_half);
      V runner1 = hn::Load(d, column.second.get() + second_half);
      V at1 = hn::Load(d, column.index.get() + second_half);

      for (size_t i = chunk; i < chunk_end; i += kRows) {
        const int32_t* const row_a = a + i * kPairs;
        const Sum zero = Sum::Zero();
        Sum s00 = zero, s01 = zero, s10 = zero, s11 = zero;
        Sum s20 = zero, s21 = zero, s30 = zero, s31 = zero;
        for (size_t k = 0; k < kPairs; ++k) {
          const VI b0 = hn::Load(di, block_b + k * block);
          const VI b1 = hn::Load(di, block_b + k * block + lanes);
          const VI a0 = hn::Set(di, row_a[k]);
          const VI a1 = hn::Set(di, row_a[kPairs + k]);
          const VI a2 = hn::Set(di, row_a[2 * kPairs + k]);
          const VI a3 = hn::Set(di, row_a[3 * kPairs + k]);
          s00.Add(a0, b0);
          s01.Add(a0, b1);
          s10.Add(a1, b0);
          s11.Add(a1, b1);
          s20.Add(a2, b0);
          s21.Add(a2, b1);
          s30.Add(a3, b0);
          s31.Add(a3, b1);
        }
        const auto take = [&](size_t r, V p0, V p1) HWY_ATTR {
          p0 = hn::IfThenElse(hn::Lt(index0, end), p0, none);
          p1 = hn::IfThenElse(hn::Lt(index1, end), p1, none);
          const size_t at = (i + r) * lanes;
          V best = hn::Load(d, row.best.get() + at);
          V second = hn::Load(d, row.second.get() + at);
          V index = hn::Load(d, row.index.get() + at);
          Enter(p0, index0, best, second, index);
          Enter(p1, index1, best, second, index);
          hn::Store(best, d, row.best.get() + at);
          hn::Store(second, d, row.second.get() + at);
          hn::Store(index, d, row.index.get() + at);
          if (i + r >= valid_a) return;
          const V here = hn::Set(d, static_cast<float>(i + r));
          Enter(p0, here, best0, runner0, at0);
          Enter(p1, here, best1, runner1, at1);
        };
        take(0, s00.Sum(), s01.Sum());
        take(1, s10.Sum(), s11.Sum());
        take(2, s20.Sum(), s21.Sum());
        take(3, s30.Sum(), s31.Sum());
      }
      hn::Store(best0, d, column.best.get() + first);
      hn::Store(runner0, d, column.second.get() + first);
      hn::Store(at0, d, column.index.get() + first);
      hn::Store(best1, d, column.best.get() + second_half);
      hn::Store(runner1, d, column.second.get() + second_half);
      hn::Store(at1, d, column.index.get() + second_half);
    }
  }
  for (size_t i = 0; i < valid_a; ++i) {
    rows[i] = OverLanes(row.best.get() + i * lanes,
                        row.second.get() + i * lanes,
                        row.index.get() + i * lanes,
                        lanes);
  }
  for (size_t j = 0; j < num_b; ++j) {
    columns[j] = {column.best[j],
                  column.second[j],
                  static_cast<uint32_t>(column.index[j])};
  }
}

}  // namespace freegs::sfm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace freegs::sfm {

HWY_EXPORT(BestProducts);

namespace {

// Pairs of values, padded to a multiple of kRows; and the length of each
// vector.
struct Prepared {
  hwy::AlignedFreeUniquePtr<int32_t[]> pairs;
  std::vector<double> lengths;
  size_t padded = 0;
};

Prepared Prepare(const SiftDescriptors& descriptors) {
  Prepared result;
  const size_t count = descriptors.count();
  result.padded = (count + kRows - 1) / kRows * kRows;
  result.pairs = hwy::AllocateAligned<int32_t>(result.padded * kPairs);
  std::fill_n(result.pairs.get(), result.padded * kPairs, 0);
  result.lengths.resize(count);
  for (size_t i = 0; i < count; ++i) {
    int64_t squared = 0;
    for (size_t k = 0; k < kSiftDimensions; ++k) {
      const int32_t value = descriptors.values[i * kSiftDimensions + k];
      squared += int64_t{value} * value;
      result.pairs[i * kPairs + k / 2] |= k % 2 == 0 ? value : value << 16;
    }
    result.lengths[i] = std::sqrt(static_cast<double>(squared));
  }
  return result;
}

// The angle to the nearest descriptor must be below this share of the angle to
// the second nearest.
constexpr double kMaxRatio = 0.8;

// The largest angle between two matching descriptors, in radians.
constexpr double kMaxAngle = 0.7;

}  // namespace

std::vector<std::pair<uint32_t, uint32_t>> MatchDescriptors(
    const SiftDescriptors& a, const SiftDescriptors& b) {
  std::vector<std::pair<uint32_t, uint32_t>> matches;
  if (a.count() == 0 || b.count() == 0) return matches;
  const Prepared pa = Prepare(a);
  const Prepared pb = Prepare(b);
  std::vector<BestTwo> rows(a.count());
  std::vector<BestTwo> columns(b.count());
  HWY_DYNAMIC_DISPATCH(BestProducts)
  (pa.pairs.get(),
   pa.padded,
   a.count(),
   pb.pairs.get(),
   b.count(),
   rows.data(),
   columns.data());

  // SIFT descriptors all have (nearly) the same length, so the largest product
  // is the smallest angle.
  const auto passes = [&](const BestTwo& two, double length, double other) {
    if (two.best <= 0 || length == 0 || other == 0) return false;
    const double scale = 1 / (length * other);
    const double best = std::acos(std::min(1.0, two.best * scale));
    const double second = std::acos(std::clamp(two.second * scale, -1.0, 1.0));
    return best <= kMaxAngle && best < kMaxRatio * second;
  };
  for (size_t i = 0; i < rows.size(); ++i) {
    const uint32_t j = rows[i].index;
    if (columns[j].index != i) continue;
    if (passes(rows[i], pa.lengths[i], pb.lengths[j]) &&
        passes(columns[j], pa.lengths[i], pb.lengths[j])) {
      matches.emplace_back(static_cast<uint32_t>(i), j);
    }
  }
  return matches;
}

}  // namespace freegs::sfm
#endif  // HWY_ONCE
