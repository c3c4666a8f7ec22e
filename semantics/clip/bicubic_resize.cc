// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/bicubic_resize.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace freegs::semantics {
namespace {

constexpr double kKernelRadius = 2;
constexpr int kPrecisionBits = 22;

double CubicKernel(double x) {
  constexpr double a = -0.5;
  x = std::abs(x);
  if (x < 1) return ((a + 2) * x - (a + 3)) * x * x + 1;
  if (x < 2) return (((x - 5) * x + 8) * x - 4) * a;
  return 0;
}

// The weights of the input pixels that make one resized pixel. The input pixels
// are consecutive and begin at `first`.
struct Taps {
  int first = 0;
  std::vector<int64_t> weights;  // In units of 2^-kPrecisionBits.
};

// Returns the weights for the resized pixels begin .. begin + count - 1.
std::vector<Taps> MakeTaps(int input_size,
                           int output_size,
                           int begin,
                           int count) {
  const double scale = static_cast<double>(input_size) / output_size;
  const double stretch = std::max(scale, 1.0);
  const double radius = kKernelRadius * stretch;
  std::vector<Taps> taps(static_cast<size_t>(count));
  std::vector<double> weights;
  for (int i = 0; i < count; ++i) {
    const double center = (begin + i + 0.5) * scale;
    const int first = std::max(0, static_cast<int>(center - radius + 0.5));
    const int last =
        std::min(input_size, static_cast<int>(center + radius + 0.5));
    weights.clear();
    double sum = 0;
    for (int x = first; x < last; ++x) {
      weights.push_back(CubicKernel((x - center + 0.5) / stretch));
      sum += weights.back();
    }
    taps[i].first = first;
    for (const double weight : weights) {
      taps[i].weights.push_back(
          std::llround(weight / sum * (int64_t{1} << kPrecisionBits)));
    }
  }
  return taps;
}

// The weighted sum of pixels that lie `stride` bytes apart.
uint8_t Combine(const uint8_t* pixels, size_t stride, const Taps& taps) {
  int64_t sum = int64_t{1} << (kPrecisionBits - 1);
  for (const int64_t weight : taps.weights) {
    sum += weight * *pixels;
    pixels += stride;
  }
  return static_cast<uint8_t>(
      std::clamp<int64_t>(sum >> kPrecisionBits, 0, 255));
}

}  // namespace

ImageU8 ResizeBicubic(const ImageU8& image,
                      int width,
                      int height,
                      const ResizeWindow& window) {
  const std::vector<Taps> columns =
      MakeTaps(image.width(), width, window.x, window.width);
  const std::vector<Taps> rows =
      MakeTaps(image.height(), height, window.y, window.height);
  if (columns.empty() || rows.empty()) return {};
  const int channels = image.channels();
  const int first_row = rows.front().first;
  const int end_row =
      rows.back().first + static_cast<int>(rows.back().weights.size());

  ImageU8 narrow(window.width, end_row - first_row, channels);
  for (int y = 0; y < narrow.height(); ++y) {
    const uint8_t* in = image.row(first_row + y);
    uint8_t* out = narrow.row(y);
    for (const Taps& taps : columns) {
      const uint8_t* pixels = in + static_cast<size_t>(taps.first) * channels;
      for (int c = 0; c < channels; ++c) {
        *out++ = Combine(pixels + c, static_cast<size_t>(channels), taps);
      }
    }
  }

  ImageU8 result(window.width, window.height, channels);
  const size_t row_bytes = static_cast<size_t>(window.width) * channels;
  for (int y = 0; y < window.height; ++y) {
    const uint8_t* in = narrow.row(rows[y].first - first_row);
    uint8_t* out = result.row(y);
    for (size_t i = 0; i < row_bytes; ++i) {
      out[i] = Combine(in + i, row_bytes, rows[y]);
    }
  }
  return result;
}

ImageU8 ResizeBicubic(const ImageU8& image, int width, int height) {
  return ResizeBicubic(image, width, height, {0, 0, width, height});
}

}  // namespace freegs::semantics
