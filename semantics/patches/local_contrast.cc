// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/local_contrast.h"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace freegs::semantics {
namespace {

// Noise of photographs: a variance of colour that says nothing. (0.05)^2.
constexpr double kNoise = 2.5e-3;

}  // namespace

ImageF ToLab(const ImageF& rgb) {
  ImageF lab(rgb.width(), rgb.height(), 3);
  const cv::Mat from(
      rgb.height(), rgb.width(), CV_32FC3, const_cast<float*>(rgb.data()));
  cv::Mat to(rgb.height(), rgb.width(), CV_32FC3, lab.data());
  cv::cvtColor(from, to, cv::COLOR_RGB2Lab);
  for (size_t i = 0; i < lab.size(); ++i) lab.data()[i] *= 0.01f;
  return lab;
}

LocalContrast::LocalContrast(const ImageF& lab)
    : width_(lab.width()),
      height_(lab.height()),
      table_(static_cast<size_t>(width_ + 1) * (height_ + 1)) {
  for (int y = 0; y < height_; ++y) {
    Sums line = {};
    const Sums* above = table_.data() + static_cast<size_t>(y) * (width_ + 1);
    Sums* here = table_.data() + static_cast<size_t>(y + 1) * (width_ + 1);
    for (int x = 0; x < width_; ++x) {
      for (int c = 0; c < 3; ++c) {
        const double value = lab(x, y, c);
        line[c] += value;
        line[3 + c] += value * value;
      }
      for (int k = 0; k < kSums; ++k)
        here[x + 1][k] = above[x + 1][k] + line[k];
    }
  }
}

int LocalContrast::Sum(int x0, int y0, int x1, int y1, Sums* sums) const {
  x0 = std::clamp(x0, 0, width_);
  x1 = std::clamp(x1, 0, width_);
  y0 = std::clamp(y0, 0, height_);
  y1 = std::clamp(y1, 0, height_);
  const auto at = [this](int x, int y) -> const Sums& {
    return table_[static_cast<size_t>(y) * (width_ + 1) + x];
  };
  const Sums& a = at(x0, y0);
  const Sums& b = at(x1, y0);
  const Sums& c = at(x0, y1);
  const Sums& d = at(x1, y1);
  for (int k = 0; k < kSums; ++k) (*sums)[k] = d[k] - b[k] - c[k] + a[k];
  return (x1 - x0) * (y1 - y0);
}

LocalContrast::Step LocalContrast::Across(int x,
                                          int y,
                                          bool horizontal,
                                          int reach) const {
  Step strongest;
  const int half = (reach + 1) / 2;
  for (int shift = -1; shift <= 1; ++shift) {
    Sums near;
    Sums far;
    int num_near;
    int num_far;
    if (horizontal) {
      const int edge = x + 1 + shift;
      num_near = Sum(edge - reach, y - half, edge, y + half + 1, &near);
      num_far = Sum(edge, y - half, edge + reach, y + half + 1, &far);
    } else {
      const int edge = y + 1 + shift;
      num_near = Sum(x - half, edge - reach, x + half + 1, edge, &near);
      num_far = Sum(x - half, edge, x + half + 1, edge + reach, &far);
    }
    if (num_near <= 0 || num_far <= 0) continue;
    double difference2 = 0;
    double variance = 0;
    for (int c = 0; c < 3; ++c) {
      const double mean_near = near[c] / num_near;
      const double mean_far = far[c] / num_far;
      difference2 += (mean_near - mean_far) * (mean_near - mean_far);
      variance += std::max(0.0, near[3 + c] / num_near - mean_near * mean_near);
      variance += std::max(0.0, far[3 + c] / num_far - mean_far * mean_far);
    }
    const Step step{.contrast = difference2 / (difference2 + variance + kNoise),
                    .difference = std::sqrt(difference2)};
    if (step.contrast > strongest.contrast) strongest = step;
  }
  return strongest;
}

}  // namespace freegs::semantics
