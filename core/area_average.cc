// SPDX-License-Identifier: BSD-3-Clause

#include "core/area_average.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace freegs {
namespace {

// A row of `size` pixels becomes one of `small` pixels. Each old pixel is
// `small` units long and each new one `size` units. Calls visit(old, new,
// units) for each two that overlap, in ascending order, with the units that
// they have in common.
template <typename Visit>
void ForEachOverlap(int size, int small, const Visit& visit) {
  int64_t begin = 0;
  for (int from = 0, to = 0; from < size && to < small;) {
    const int64_t from_end = int64_t{from + 1} * small;
    const int64_t to_end = int64_t{to + 1} * size;
    const int64_t end = std::min(from_end, to_end);
    visit(from, to, static_cast<uint32_t>(end - begin));
    begin = end;
    from += from_end == end;
    to += to_end == end;
  }
}

}  // namespace

ImageU8 AreaAverage(const ImageU8& image, int width, int height) {
  const int channels = image.channels();
  ImageU8 result(width, height, channels);
  const size_t row_size = static_cast<size_t>(width) * channels;
  std::vector<uint32_t> row(row_size);   // Sums along the newest old row.
  std::vector<uint64_t> sums(row_size);  // Sums of the new row.
  const uint64_t area = uint64_t{static_cast<uint32_t>(image.width())} *
                        static_cast<uint32_t>(image.height());
  int newest = -1;
  int64_t covered = 0;  // Units of the new row that are in `sums`.
  ForEachOverlap(image.height(), height, [&](int y, int to, uint32_t rows) {
    if (y != newest) {
      newest = y;
      std::fill(row.begin(), row.end(), 0);
      const uint8_t* pixels =
          image.data() + static_cast<size_t>(y) * image.width() * channels;
      ForEachOverlap(image.width(), width, [&](int x, int column, uint32_t n) {
        for (int c = 0; c < channels; ++c) {
          row[static_cast<size_t>(column) * channels + c] +=
              n * pixels[static_cast<size_t>(x) * channels + c];
        }
      });
    }
    for (size_t k = 0; k < row_size; ++k) sums[k] += uint64_t{rows} * row[k];
    covered += rows;
    if (covered < image.height()) return;
    covered = 0;
    uint8_t* out = result.data() + to * row_size;
    for (size_t k = 0; k < row_size; ++k) {
      out[k] = static_cast<uint8_t>((sums[k] + area / 2) / area);
      sums[k] = 0;
    }
  });
  return result;
}

}  // namespace freegs
