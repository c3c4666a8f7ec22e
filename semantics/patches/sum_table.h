// SPDX-License-Identifier: BSD-3-Clause
// Sums over windows of an image that cost the same for any size (integral
// images, summed-area tables).

#ifndef FREEGS_SEMANTICS_PATCHES_SUM_TABLE_H_
#define FREEGS_SEMANTICS_PATCHES_SUM_TABLE_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace freegs::semantics {

// Sums over windows of an image that has N numbers for each pixel.
template <size_t N>
class SumTable {
 public:
  using Sums = std::array<double, N>;

  // pixel(x, y) returns the Sums of one pixel.
  template <typename PixelFn>
  SumTable(int width, int height, const PixelFn& pixel)
      : width_(width),
        height_(height),
        table_(static_cast<size_t>(width + 1) * (height + 1)) {
    for (int y = 0; y < height; ++y) {
      Sums line = {};
      const Sums* above = table_.data() + static_cast<size_t>(y) * (width + 1);
      Sums* here = table_.data() + static_cast<size_t>(y + 1) * (width + 1);
      for (int x = 0; x < width; ++x) {
        const Sums added = pixel(x, y);
        for (size_t k = 0; k < N; ++k) {
          line[k] += added[k];
          here[x + 1][k] = above[x + 1][k] + line[k];
        }
      }
    }
  }

  // Sums over the pixels x0 <= x < x1, y0 <= y < y1, clipped to the image;
  // returns how many these are.
  int Sum(int x0, int y0, int x1, int y1, Sums* sums) const {
    x0 = std::clamp(x0, 0, width_);
    x1 = std::clamp(x1, 0, width_);
    y0 = std::clamp(y0, 0, height_);
    y1 = std::clamp(y1, 0, height_);
    const Sums& a = At(x0, y0);
    const Sums& b = At(x1, y0);
    const Sums& c = At(x0, y1);
    const Sums& d = At(x1, y1);
    for (size_t k = 0; k < N; ++k) (*sums)[k] = d[k] - b[k] - c[k] + a[k];
    return (x1 - x0) * (y1 - y0);
  }

 private:
  const Sums& At(int x, int y) const {
    return table_[static_cast<size_t>(y) * (width_ + 1) + x];
  }

  int width_;
  int height_;
  std::vector<Sums> table_;  // (width + 1) x (height + 1).
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_SUM_TABLE_H_
