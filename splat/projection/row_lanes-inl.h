// SPDX-License-Identifier: BSD-3-Clause
// Moves rows of floats between memory and SIMD vectors that hold one row per
// lane: rows of a model's arrays, or small structs of floats.

// Compiled anew for each instruction set: see hwy/highway.h on -inl.h files.
#if defined(FREEGS_SPLAT_PROJECTION_ROW_LANES_INL_H_) == \
    defined(HWY_TARGET_TOGGLE)
#ifdef FREEGS_SPLAT_PROJECTION_ROW_LANES_INL_H_
#undef FREEGS_SPLAT_PROJECTION_ROW_LANES_INL_H_
#else
#define FREEGS_SPLAT_PROJECTION_ROW_LANES_INL_H_
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "splat/projection/simd_number-inl.h"

HWY_BEFORE_NAMESPACE();
namespace freegs::splat::HWY_NAMESPACE {

// The most lanes that a SimdNumber has.
inline constexpr size_t kMaxLanes = 16;

// A group of Gaussians: as many as a vector has lanes, or fewer at the end.
struct Group {
  const uint32_t* indices;  // Rows of a model, or of gradients.
  size_t count;
  bool consecutive;  // A whole vector of neighbours.
};

HWY_INLINE Group MakeGroup(const uint32_t* indices, size_t count) {
  const size_t lanes = hwy::HWY_NAMESPACE::Lanes(SimdNumber::Tag());
  Group group{indices, std::min(count, lanes), false};
  group.consecutive =
      group.count == lanes && indices[lanes - 1] - indices[0] == lanes - 1;
  return group;
}

// Rows of 3 or 4 floats of a model's array, into as many numbers. Lanes beyond
// the group are zero.
template <int kStride>
HWY_INLINE void LoadRows(const Group& group,
                         const float* array,
                         SimdNumber out[kStride]) {
  const SimdNumber::Tag d;
  HWY_ALIGN float rows[kStride * kMaxLanes];
  const float* from = array + static_cast<size_t>(group.indices[0]) * kStride;
  if (!group.consecutive) {
    std::fill_n(rows, kStride * kMaxLanes, 0.0f);
    for (size_t l = 0; l < group.count; ++l) {
      const float* row =
          array + static_cast<size_t>(group.indices[l]) * kStride;
      for (int k = 0; k < kStride; ++k) rows[kStride * l + k] = row[k];
    }
    from = rows;
  }
  if constexpr (kStride == 3) {
    hwy::HWY_NAMESPACE::LoadInterleaved3(
        d, from, out[0].vector, out[1].vector, out[2].vector);
  } else {
    hwy::HWY_NAMESPACE::LoadInterleaved4(
        d, from, out[0].vector, out[1].vector, out[2].vector, out[3].vector);
  }
}

template <int kStride>
HWY_INLINE void StoreRows(const Group& group,
                          const SimdNumber values[kStride],
                          float* array) {
  const SimdNumber::Tag d;
  HWY_ALIGN float rows[kStride * kMaxLanes];
  float* to = group.consecutive
                  ? array + static_cast<size_t>(group.indices[0]) * kStride
                  : rows;
  if constexpr (kStride == 3) {
    hwy::HWY_NAMESPACE::StoreInterleaved3(
        values[0].vector, values[1].vector, values[2].vector, d, to);
  } else {
    hwy::HWY_NAMESPACE::StoreInterleaved4(values[0].vector,
                                          values[1].vector,
                                          values[2].vector,
                                          values[3].vector,
                                          d,
                                          to);
  }
  if (group.consecutive) return;
  for (size_t l = 0; l < group.count; ++l) {
    float* row = array + static_cast<size_t>(group.indices[l]) * kStride;
    for (int k = 0; k < kStride; ++k) row[k] = rows[kStride * l + k];
  }
}

// The row of each lane. Lanes without a row of their own must point to memory
// that may be read, or written to, as well.
template <typename Float>
struct LaneRows {
  Float* of_lane[kMaxLanes];
};

#if HWY_TARGET == HWY_SCALAR
template <typename Float>
HWY_INLINE void LoadColumns(const LaneRows<Float>& rows,
                            size_t first,
                            SimdNumber out[4]) {
  for (int c = 0; c < 4; ++c) out[c] = SimdNumber(rows.of_lane[0][first + c]);
}

HWY_INLINE void StoreColumns(const SimdNumber in[4],
                             const LaneRows<float>& rows,
                             size_t first) {
  for (int c = 0; c < 4; ++c) {
    hwy::HWY_NAMESPACE::Store(
        in[c].vector, SimdNumber::Tag(), rows.of_lane[0] + first + c);
  }
}
#else
// Transposes the 4 x 4 matrix that block b of the four vectors is, for each b.
HWY_INLINE void TransposeBlocks(const SimdNumber in[4], SimdNumber out[4]) {
  namespace hn = hwy::HWY_NAMESPACE;
  const SimdNumber::Tag d;
  const hn::Repartition<uint64_t, SimdNumber::Tag> pairs;
  const auto lower = [&](int a, int b) HWY_ATTR {
    return hn::BitCast(pairs,
                       hn::InterleaveLower(d, in[a].vector, in[b].vector));
  };
  const auto upper = [&](int a, int b) HWY_ATTR {
    return hn::BitCast(pairs,
                       hn::InterleaveUpper(d, in[a].vector, in[b].vector));
  };
  const auto lower01 = lower(0, 1), lower23 = lower(2, 3);
  const auto upper01 = upper(0, 1), upper23 = upper(2, 3);
  out[0] = hn::BitCast(d, hn::InterleaveLower(pairs, lower01, lower23));
  out[1] = hn::BitCast(d, hn::InterleaveUpper(pairs, lower01, lower23));
  out[2] = hn::BitCast(d, hn::InterleaveLower(pairs, upper01, upper23));
  out[3] = hn::BitCast(d, hn::InterleaveUpper(pairs, upper01, upper23));
}

// Block b of the result is columns [first, first + 4) of the row of lane
// 4 b + r.
template <class D, typename Float>
HWY_INLINE hwy::HWY_NAMESPACE::Vec<D> LoadBlocks(D d,
                                                 const LaneRows<Float>& rows,
                                                 size_t r,
                                                 size_t first) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::CappedTag<float, 4> d4;
  const auto row = [&](size_t lane) HWY_ATTR {
    return hn::LoadU(d4, rows.of_lane[lane] + first);
  };
  if constexpr (hn::MaxLanes(d) == 16) {
    const hn::Half<D> d8;
    return hn::Combine(d,
                       hn::Combine(d8, row(r + 12), row(r + 8)),
                       hn::Combine(d8, row(r + 4), row(r)));
  } else if constexpr (hn::MaxLanes(d) == 8) {
    return hn::Combine(d, row(r + 4), row(r));
  } else {
    static_assert(hn::MaxLanes(d) == 4);
    return row(r);
  }
}

template <class D>
HWY_INLINE void StoreBlocks(D d,
                            hwy::HWY_NAMESPACE::Vec<D> blocks,
                            const LaneRows<float>& rows,
                            size_t r,
                            size_t first) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::CappedTag<float, 4> d4;
  const auto store = [&](size_t lane, auto row) HWY_ATTR {
    hn::StoreU(row, d4, rows.of_lane[lane] + first);
  };
  if constexpr (hn::MaxLanes(d) == 16) {
    const hn::Half<D> d8;
    const auto low = hn::LowerHalf(d8, blocks);
    const auto high = hn::UpperHalf(d8, blocks);
    store(r, hn::LowerHalf(d4, low));
    store(r + 4, hn::UpperHalf(d4, low));
    store(r + 8, hn::LowerHalf(d4, high));
    store(r + 12, hn::UpperHalf(d4, high));
  } else if constexpr (hn::MaxLanes(d) == 8) {
    store(r, hn::LowerHalf(d4, blocks));
    store(r + 4, hn::UpperHalf(d4, blocks));
  } else {
    static_assert(hn::MaxLanes(d) == 4);
    store(r, blocks);
  }
}

// out[c] gets column first + c of the rows.
template <typename Float>
HWY_INLINE void LoadColumns(const LaneRows<Float>& rows,
                            size_t first,
                            SimdNumber out[4]) {
  SimdNumber blocks[4];
  for (size_t r = 0; r < 4; ++r) {
    blocks[r] = LoadBlocks(SimdNumber::Tag(), rows, r, first);
  }
  TransposeBlocks(blocks, out);
}

// Writes in[c] to column first + c of the rows.
HWY_INLINE void StoreColumns(const SimdNumber in[4],
                             const LaneRows<float>& rows,
                             size_t first) {
  SimdNumber blocks[4];
  TransposeBlocks(in, blocks);
  for (size_t r = 0; r < 4; ++r) {
    StoreBlocks(SimdNumber::Tag(), blocks[r].vector, rows, r, first);
  }
}
#endif

// One column of the rows.
HWY_INLINE SimdNumber LoadColumn(const LaneRows<const float>& rows,
                                 size_t column) {
  const SimdNumber::Tag d;
  HWY_ALIGN float lanes[kMaxLanes];
  for (size_t l = 0; l < hwy::HWY_NAMESPACE::Lanes(d); ++l) {
    lanes[l] = rows.of_lane[l][column];
  }
  return hwy::HWY_NAMESPACE::Load(d, lanes);
}

HWY_INLINE void StoreColumn(SimdNumber numbers,
                            const LaneRows<float>& rows,
                            size_t column) {
  const SimdNumber::Tag d;
  HWY_ALIGN float lanes[kMaxLanes];
  hwy::HWY_NAMESPACE::Store(numbers.vector, d, lanes);
  for (size_t l = 0; l < hwy::HWY_NAMESPACE::Lanes(d); ++l) {
    rows.of_lane[l][column] = lanes[l];
  }
}

// The rows are `count` colours of three floats each. Calls visit(k, color) for
// each of them, with color[3] the colours number k of all lanes.
template <typename Visit>
HWY_INLINE void ForEachColor(const LaneRows<const float>& rows,
                             int count,
                             const Visit& visit) {
  int k = 0;
  for (; k + 4 <= count; k += 4) {
    SimdNumber columns[12];
    for (int q = 0; q < 3; ++q)
      LoadColumns(rows, 3 * k + 4 * q, columns + 4 * q);
    for (int q = 0; q < 4; ++q) visit(k + q, columns + 3 * q);
  }
  if (k + 3 == count) {
    SimdNumber columns[9];
    for (int q = 0; q < 2; ++q)
      LoadColumns(rows, 3 * k + 4 * q, columns + 4 * q);
    columns[8] = LoadColumn(rows, 3 * k + 8);
    for (int q = 0; q < 3; ++q) visit(k + q, columns + 3 * q);
    return;
  }
  for (; k < count; ++k) {
    SimdNumber color[3];
    for (int c = 0; c < 3; ++c) color[c] = LoadColumn(rows, 3 * k + c);
    visit(k, color);
  }
}

// The opposite: make(k, color) sets color[3] to the colours number k of all
// lanes, which are written to the rows.
template <typename Make>
HWY_INLINE void StoreColors(const LaneRows<float>& rows,
                            int count,
                            const Make& make) {
  int k = 0;
  for (; k + 4 <= count; k += 4) {
    SimdNumber columns[12];
    for (int q = 0; q < 4; ++q) make(k + q, columns + 3 * q);
    for (int q = 0; q < 3; ++q)
      StoreColumns(columns + 4 * q, rows, 3 * k + 4 * q);
  }
  if (k + 3 == count) {
    SimdNumber columns[9];
    for (int q = 0; q < 3; ++q) make(k + q, columns + 3 * q);
    for (int q = 0; q < 2; ++q)
      StoreColumns(columns + 4 * q, rows, 3 * k + 4 * q);
    StoreColumn(columns[8], rows, 3 * k + 8);
    return;
  }
  for (; k < count; ++k) {
    SimdNumber color[3];
    make(k, color);
    for (int c = 0; c < 3; ++c) StoreColumn(color[c], rows, 3 * k + c);
  }
}

}  // namespace freegs::splat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // FREEGS_SPLAT_PROJECTION_ROW_LANES_INL_H_
