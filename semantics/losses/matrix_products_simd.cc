// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/matrix_products_simd.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "semantics/losses/matrix_products_simd.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace freegs::semantics::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, 16>;

// The number of terms at a time. A panel of b with so many rows, two vectors
// wide, stays in the first level of the cache while all rows of a are read.
constexpr size_t kTerms = 256;
constexpr size_t kMaxPanelWidth = 2 * 16;

// panel(k, j) = b(k, j) for the columns of the panel; zeros beyond `cols`.
void Pack(const Strided& b,
          size_t terms,
          size_t cols,
          size_t width,
          float* HWY_RESTRICT panel) {
  if (cols < width) std::fill_n(panel, terms * width, 0.0f);
  if (b.col_step == 1) {
    for (size_t k = 0; k < terms; ++k) {
      std::copy_n(b.data + k * b.row_step, cols, panel + k * width);
    }
    return;
  }
  for (size_t j = 0; j < cols; ++j) {
    const float* column = b.data + j * b.col_step;
    for (size_t k = 0; k < terms; ++k) {
      panel[k * width + j] = column[k * b.row_step];
    }
  }
}

// Adds the product of four rows of a with a panel to a tile of the result. It
// has eight independent sums, so that no addition waits for the one before.
HWY_INLINE void AddFourRows(const Strided& a,
                            size_t terms,
                            const float* HWY_RESTRICT panel,
                            float* HWY_RESTRICT result,
                            size_t step) {
  const Tag d;
  const size_t lanes = hn::Lanes(d);
  const float* HWY_RESTRICT row0 = a.data;
  const float* HWY_RESTRICT row1 = row0 + a.row_step;
  const float* HWY_RESTRICT row2 = row1 + a.row_step;
  const float* HWY_RESTRICT row3 = row2 + a.row_step;
  auto left0 = hn::Zero(d);
  auto left1 = hn::Zero(d);
  auto left2 = hn::Zero(d);
  auto left3 = hn::Zero(d);
  auto right0 = hn::Zero(d);
  auto right1 = hn::Zero(d);
  auto right2 = hn::Zero(d);
  auto right3 = hn::Zero(d);
  for (size_t k = 0; k < terms; ++k, panel += 2 * lanes) {
    const auto left = hn::Load(d, panel);
    const auto right = hn::Load(d, panel + lanes);
    const size_t at = k * a.col_step;
    const auto a0 = hn::Set(d, row0[at]);
    left0 = hn::MulAdd(a0, left, left0);
    right0 = hn::MulAdd(a0, right, right0);
    const auto a1 = hn::Set(d, row1[at]);
    left1 = hn::MulAdd(a1, left, left1);
    right1 = hn::MulAdd(a1, right, right1);
    const auto a2 = hn::Set(d, row2[at]);
    left2 = hn::MulAdd(a2, left, left2);
    right2 = hn::MulAdd(a2, right, right2);
    const auto a3 = hn::Set(d, row3[at]);
    left3 = hn::MulAdd(a3, left, left3);
    right3 = hn::MulAdd(a3, right, right3);
  }
  const auto add = [&](auto sum_left, auto sum_right, size_t row) HWY_ATTR {
    float* out = result + row * step;
    hn::StoreU(hn::Add(hn::LoadU(d, out), sum_left), d, out);
    out += lanes;
    hn::StoreU(hn::Add(hn::LoadU(d, out), sum_right), d, out);
  };
  add(left0, right0, 0);
  add(left1, right1, 1);
  add(left2, right2, 2);
  add(left3, right3, 3);
}

// Does what AddFourRows does, for a tile at the edges of the result. It works
// on a copy, in which the last row stands for the missing ones.
void AddEdge(const Strided& a,
             size_t rows,
             size_t terms,
             const float* panel,
             size_t cols,
             float* result,
             size_t step) {
  const size_t width = 2 * hn::Lanes(Tag());
  HWY_ALIGN float tile[4 * kMaxPanelWidth] = {};
  HWY_ALIGN float packed[4 * kTerms];
  for (size_t i = 0; i < 4; ++i) {
    const float* row = a.data + std::min(i, rows - 1) * a.row_step;
    for (size_t k = 0; k < terms; ++k) packed[4 * k + i] = row[k * a.col_step];
  }
  AddFourRows({packed, 1, 4}, terms, panel, tile, width);
  for (size_t i = 0; i < rows; ++i) {
    for (size_t j = 0; j < cols; ++j) {
      result[i * step + j] += tile[i * width + j];
    }
  }
}

void AddColumns(const Strided& a,
                const Strided& b,
                size_t rows,
                size_t terms,
                size_t first,
                size_t last,
                float* result,
                size_t cols) {
  HWY_ALIGN float panel[kTerms * kMaxPanelWidth];
  const size_t width = 2 * hn::Lanes(Tag());
  for (size_t j = first; j < last; j += width) {
    const size_t panel_cols = std::min(width, last - j);
    for (size_t k = 0; k < terms; k += kTerms) {
      const size_t panel_terms = std::min(kTerms, terms - k);
      Pack({b.data + k * b.row_step + j * b.col_step, b.row_step, b.col_step},
           panel_terms,
           panel_cols,
           width,
           panel);
      for (size_t i = 0; i < rows; i += 4) {
        const Strided block = {
            a.data + i * a.row_step + k * a.col_step, a.row_step, a.col_step};
        float* tile = result + i * cols + j;
        if (i + 4 <= rows && panel_cols == width) {
          AddFourRows(block, panel_terms, panel, tile, cols);
        } else {
          AddEdge(block,
                  std::min<size_t>(4, rows - i),
                  panel_terms,
                  panel,
                  panel_cols,
                  tile,
                  cols);
        }
      }
    }
  }
}

}  // namespace freegs::semantics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace freegs::semantics {

HWY_EXPORT(AddColumns);

void AddProductColumns(const Strided& a,
                       const Strided& b,
                       size_t rows,
                       size_t terms,
                       size_t first,
                       size_t last,
                       float* result,
                       size_t cols) {
  HWY_DYNAMIC_DISPATCH(AddColumns)
  (a, b, rows, terms, first, last, result, cols);
}

}  // namespace freegs::semantics
#endif  // HWY_ONCE
