// SPDX-License-Identifier: BSD-3-Clause

#include "splat/optim/image_metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace freegs::splat {
namespace {

constexpr int kRadius = 5;
constexpr double kSigma = 1.5;
constexpr double kC1 = 0.01 * 0.01;
constexpr double kC2 = 0.03 * 0.03;

Status CheckPair(const ImageF& a, const ImageF& b) {
  const auto size = [](const ImageF& image) {
    return std::to_string(image.width()) + "x" +
           std::to_string(image.height()) + "x" +
           std::to_string(image.channels());
  };
  if (a.empty() || a.width() != b.width() || a.height() != b.height() ||
      a.channels() != b.channels()) {
    return InvalidArgumentError("images of different or zero size: " + size(a) +
                                " and " + size(b));
  }
  const auto is_nan = [](float v) { return std::isnan(v); };
  if (std::any_of(a.data(), a.data() + a.size(), is_nan) ||
      std::any_of(b.data(), b.data() + b.size(), is_nan)) {
    return InvalidArgumentError("an image holds values that are not numbers");
  }
  return Status();
}

double Clamped(float v) { return std::clamp(static_cast<double>(v), 0.0, 1.0); }

std::array<double, 2 * kRadius + 1> GaussianWindow() {
  std::array<double, 2 * kRadius + 1> window;
  double sum = 0;
  for (int i = -kRadius; i <= kRadius; ++i) {
    window[i + kRadius] = std::exp(-0.5 * i * i / (kSigma * kSigma));
    sum += window[i + kRadius];
  }
  for (double& weight : window) weight /= sum;
  return window;
}

// One channel's plane, filtered along rows and then columns.
std::vector<double> Filter(const std::vector<double>& plane,
                           int width,
                           int height,
                           const std::array<double, 2 * kRadius + 1>& window) {
  std::vector<double> rows(plane.size());
  std::vector<double> result(plane.size(), 0.0);
  for (int y = 0; y < height; ++y) {
    const double* source = plane.data() + static_cast<size_t>(y) * width;
    double* target = rows.data() + static_cast<size_t>(y) * width;
    for (int x = 0; x < width; ++x) {
      const int first = std::max(-kRadius, -x);
      const int last = std::min(kRadius, width - 1 - x);
      double sum = 0;
      for (int i = first; i <= last; ++i) {
        sum += window[i + kRadius] * source[x + i];
      }
      target[x] = sum;
    }
  }
  for (int y = 0; y < height; ++y) {
    double* target = result.data() + static_cast<size_t>(y) * width;
    const int first = std::max(-kRadius, -y);
    const int last = std::min(kRadius, height - 1 - y);
    for (int i = first; i <= last; ++i) {
      const double* source = rows.data() + static_cast<size_t>(y + i) * width;
      for (int x = 0; x < width; ++x) {
        target[x] += window[i + kRadius] * source[x];
      }
    }
  }
  return result;
}

}  // namespace

StatusOr<double> Psnr(const ImageF& image, const ImageF& reference) {
  FREEGS_RETURN_IF_ERROR(CheckPair(image, reference));
  double sum = 0;
  for (size_t i = 0; i < image.size(); ++i) {
    const double d = Clamped(image.data()[i]) - Clamped(reference.data()[i]);
    sum += d * d;
  }
  const double mean = sum / static_cast<double>(image.size());
  return mean > 0 ? std::min(kMaxPsnr, -10 * std::log10(mean)) : kMaxPsnr;
}

StatusOr<double> Ssim(const ImageF& image,
                      const ImageF& reference,
                      const ImageU8* mask) {
  FREEGS_RETURN_IF_ERROR(CheckPair(image, reference));
  if (mask != nullptr &&
      (mask->width() != image.width() || mask->height() != image.height())) {
    return InvalidArgumentError("the mask is not as large as the image");
  }
  const auto used = [mask](size_t pixel) {
    return mask == nullptr || mask->data()[pixel] != 0;
  };
  const int width = image.width();
  const int height = image.height();
  const std::array<double, 2 * kRadius + 1> window = GaussianWindow();
  const size_t count = image.num_pixels();
  std::vector<double> a(count);
  std::vector<double> b(count);
  std::vector<double> product(count);
  double sum = 0;
  size_t num_used = 0;
  for (int channel = 0; channel < image.channels(); ++channel) {
    for (size_t i = 0; i < count; ++i) {
      a[i] = Clamped(image.data()[i * image.channels() + channel]);
      b[i] = Clamped(reference.data()[i * image.channels() + channel]);
    }
    const auto filter_product = [&](const std::vector<double>& u,
                                    const std::vector<double>& v) {
      std::transform(u.begin(),
                     u.end(),
                     v.begin(),
                     product.begin(),
                     [](double x, double y) { return x * y; });
      return Filter(product, width, height, window);
    };
    const std::vector<double> mean_a = Filter(a, width, height, window);
    const std::vector<double> mean_b = Filter(b, width, height, window);
    const std::vector<double> square_a = filter_product(a, a);
    const std::vector<double> square_b = filter_product(b, b);
    const std::vector<double> cross = filter_product(a, b);
    for (size_t i = 0; i < count; ++i) {
      if (!used(i)) continue;
      ++num_used;
      const double ma = mean_a[i];
      const double mb = mean_b[i];
      const double variance_a = square_a[i] - ma * ma;
      const double variance_b = square_b[i] - mb * mb;
      const double covariance = cross[i] - ma * mb;
      sum += (2 * ma * mb + kC1) * (2 * covariance + kC2) /
             ((ma * ma + mb * mb + kC1) * (variance_a + variance_b + kC2));
    }
  }
  if (num_used == 0) {
    return InvalidArgumentError("the mask leaves no pixel to compare");
  }
  return sum / static_cast<double>(num_used);
}

}  // namespace freegs::splat
