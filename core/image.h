// SPDX-License-Identifier: BSD-3-Clause
// A dense image, rows top to bottom, channels interleaved.

#ifndef FREEGS_CORE_IMAGE_H_
#define FREEGS_CORE_IMAGE_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace freegs {

// height x width x channels, row-major, channels interleaved. Colour is RGB
// (not BGR). Pixel (x, y) covers [x, x+1) x [y, y+1): its centre is at +0.5.
template <typename T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, int channels, T fill = T())
      : width_(width),
        height_(height),
        channels_(channels),
        data_(static_cast<size_t>(width) * height * channels, fill) {}

  // Changes the shape. The values are unspecified afterwards. The memory is
  // kept when it is large enough, so that a loop over images need not allocate.
  void Reshape(int width, int height, int channels) {
    width_ = width;
    height_ = height;
    channels_ = channels;
    data_.resize(static_cast<size_t>(width) * height * channels);
  }

  int width() const { return width_; }
  int height() const { return height_; }
  int channels() const { return channels_; }
  bool empty() const { return data_.empty(); }
  size_t num_pixels() const { return static_cast<size_t>(width_) * height_; }

  T* data() { return data_.data(); }
  const T* data() const { return data_.data(); }
  size_t size() const { return data_.size(); }

  T* row(int y) { return data() + static_cast<size_t>(y) * width_ * channels_; }
  const T* row(int y) const {
    return data() + static_cast<size_t>(y) * width_ * channels_;
  }

  T& operator()(int x, int y, int channel = 0) {
    return row(y)[static_cast<size_t>(x) * channels_ + channel];
  }
  const T& operator()(int x, int y, int channel = 0) const {
    return row(y)[static_cast<size_t>(x) * channels_ + channel];
  }

 private:
  int width_ = 0;
  int height_ = 0;
  int channels_ = 0;
  std::vector<T> data_;
};

using ImageU8 = Image<uint8_t>;
using ImageU16 = Image<uint16_t>;
using ImageF = Image<float>;  // Colour in [0, 1] unless said otherwise.

// Whether the sides of two sizes have the same ratio, up to the 1 % that
// rounding to whole pixels explains.
inline bool SameShape(double width_a,
                      double height_a,
                      double width_b,
                      double height_b) {
  constexpr double kTolerance = 0.01;
  const double a = width_a * height_b;
  const double b = width_b * height_a;
  return std::abs(a - b) <= kTolerance * std::max(a, b);
}

}  // namespace freegs

#endif  // FREEGS_CORE_IMAGE_H_
