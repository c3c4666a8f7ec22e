// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/joint_bilateral_upsampling.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

namespace freegs::semantics {
namespace {

constexpr int kMaxRadius = 16;
constexpr int64_t kPixelGrain = 256;
constexpr uint64_t kMaxValues = uint64_t{1} << 31;

// The mean colour of the guide below each cell.
ImageF CellColors(const ImageF& guide, int width, int height) {
  // At least one pixel, also where the guide is smaller than the grid.
  const auto edge = [](int cell, int cells, int pixels) {
    return static_cast<int>(int64_t{cell} * pixels / cells);
  };
  ImageF colors(width, height, 3);
  for (int j = 0; j < height; ++j) {
    const int top = edge(j, height, guide.height());
    const int bottom = std::max(top + 1, edge(j + 1, height, guide.height()));
    for (int i = 0; i < width; ++i) {
      const int left = edge(i, width, guide.width());
      const int right = std::max(left + 1, edge(i + 1, width, guide.width()));
      double sum[3] = {};
      for (int y = top; y < bottom; ++y) {
        for (int x = left; x < right; ++x) {
          for (int c = 0; c < 3; ++c) sum[c] += guide(x, y, c);
        }
      }
      const double pixels = static_cast<double>(bottom - top) * (right - left);
      for (int c = 0; c < 3; ++c) {
        colors(i, j, c) = static_cast<float>(sum[c] / pixels);
      }
    }
  }
  return colors;
}

class Upsampler {
 public:
  Upsampler(const ImageF& features,
            const ImageF& guide,
            const JointBilateralOptions& options)
      : features_(features),
        guide_(guide),
        colors_(CellColors(guide, features.width(), features.height())),
        radius_(options.radius),
        spatial_(-0.5 / (options.spatial_sigma * options.spatial_sigma)),
        range_(-0.5 / (options.range_sigma * options.range_sigma)) {}

  // Writes the feature of guide pixel (x, y).
  void At(int x, int y, float* out) const {
    // The pixel's place in cells, with cell centres at whole numbers.
    const double u = (x + 0.5) * features_.width() / guide_.width() - 0.5;
    const double v = (y + 0.5) * features_.height() / guide_.height() - 0.5;
    const Taps columns = TapsAround(u, features_.width());
    const Taps rows = TapsAround(v, features_.height());

    double weights[(2 * kMaxRadius + 1) * (2 * kMaxRadius + 1)];
    double largest = -HUGE_VAL;
    int count = 0;
    for (int j = rows.first; j <= rows.last; ++j) {
      for (int i = columns.first; i <= columns.last; ++i) {
        double difference = 0;
        for (int c = 0; c < 3; ++c) {
          const double d = guide_(x, y, c) - colors_(i, j, c);
          difference += d * d;
        }
        const double exponent =
            spatial_ * ((u - i) * (u - i) + (v - j) * (v - j)) +
            range_ * difference;
        weights[count++] = exponent;
        largest = std::max(largest, exponent);
      }
    }
    // Weights are relative to the largest. Otherwise all of them would be
    // rounded to zero for a colour that is unlike all around it.
    double sum = 0;
    for (int k = 0; k < count; ++k) {
      weights[k] = std::exp(weights[k] - largest);
      sum += weights[k];
    }
    const int channels = features_.channels();
    std::fill(out, out + channels, 0.0f);
    count = 0;
    for (int j = rows.first; j <= rows.last; ++j) {
      for (int i = columns.first; i <= columns.last; ++i) {
        const auto weight = static_cast<float>(weights[count++] / sum);
        const float* cell = &features_(i, j);
        for (int c = 0; c < channels; ++c) out[c] += weight * cell[c];
      }
    }
  }

 private:
  struct Taps {
    int first;
    int last;
  };

  Taps TapsAround(double position, int cells) const {
    const int own =
        std::clamp(static_cast<int>(std::lround(position)), 0, cells - 1);
    return {std::max(0, own - radius_), std::min(cells - 1, own + radius_)};
  }

  const ImageF& features_;
  const ImageF& guide_;
  const ImageF colors_;
  const int radius_;
  const double spatial_;
  const double range_;
};

Status CheckInput(const ImageF& features,
                  const ImageF& guide,
                  uint64_t num_pixels,
                  const JointBilateralOptions& options) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  if (features.empty()) {
    return InvalidArgumentError("there are no features to upsample");
  }
  if (guide.empty() || guide.channels() != 3) {
    return InvalidArgumentError(
        "the guide of upsampling must be an RGB image that is not empty");
  }
  const auto channels = static_cast<uint64_t>(features.channels());
  if (num_pixels > kMaxValues / channels) {
    return InvalidArgumentError(
        std::to_string(num_pixels) + " pixels of " + std::to_string(channels) +
        " features are too many; upsample to a smaller guide");
  }
  return Status();
}

}  // namespace

Status JointBilateralOptions::Check() const {
  if (radius < 0 || radius > kMaxRadius) {
    return InvalidArgumentError("the radius of upsampling must lie in 0 .. " +
                                std::to_string(kMaxRadius));
  }
  for (const double sigma : {spatial_sigma, range_sigma}) {
    if (!(sigma >= 1e-3 && sigma <= 1e3)) {
      return InvalidArgumentError(
          "the sigmas of upsampling must lie in 0.001 .. 1000");
    }
  }
  return Status();
}

StatusOr<ImageF> JointBilateralUpsample(const ImageF& features,
                                        const ImageF& guide,
                                        const JointBilateralOptions& options,
                                        ThreadPool& pool) {
  FREEGS_RETURN_IF_ERROR(
      CheckInput(features, guide, guide.num_pixels(), options));
  const Upsampler upsampler(features, guide, options);
  ImageF result(guide.width(), guide.height(), features.channels());
  pool.ParallelFor(0, guide.height(), 1, [&](int64_t first, int64_t last, int) {
    for (auto y = static_cast<int>(first); y < last; ++y) {
      for (int x = 0; x < guide.width(); ++x) {
        upsampler.At(x, y, &result(x, y));
      }
    }
  });
  return result;
}

StatusOr<std::vector<float>> JointBilateralUpsampleAt(
    const ImageF& features,
    const ImageF& guide,
    std::span<const PixelIndex> pixels,
    const JointBilateralOptions& options,
    ThreadPool& pool) {
  FREEGS_RETURN_IF_ERROR(CheckInput(features, guide, pixels.size(), options));
  for (const PixelIndex& pixel : pixels) {
    if (pixel.x < 0 || pixel.x >= guide.width() || pixel.y < 0 ||
        pixel.y >= guide.height()) {
      return InvalidArgumentError(
          "a pixel to upsample at, (" + std::to_string(pixel.x) + ", " +
          std::to_string(pixel.y) + "), lies outside the guide");
    }
  }
  const Upsampler upsampler(features, guide, options);
  const auto channels = static_cast<size_t>(features.channels());
  std::vector<float> result(pixels.size() * channels);
  pool.ParallelFor(
      0,
      static_cast<int64_t>(pixels.size()),
      kPixelGrain,
      [&](int64_t first, int64_t last, int) {
        for (auto k = static_cast<size_t>(first); k < static_cast<size_t>(last);
             ++k) {
          upsampler.At(pixels[k].x, pixels[k].y, result.data() + k * channels);
        }
      });
  return result;
}

}  // namespace freegs::semantics
