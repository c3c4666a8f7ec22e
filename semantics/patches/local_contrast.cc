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
    : table_(lab.width(), lab.height(), [&lab](int x, int y) {
        SumTable<kSums>::Sums pixel;
        for (int c = 0; c < 3; ++c) {
          const double value = lab(x, y, c);
          pixel[c] = value;
          pixel[3 + c] = value * value;
        }
        return pixel;
      }) {}

LocalContrast::Step LocalContrast::Across(int x,
                                          int y,
                                          bool horizontal,
                                          int reach) const {
  Step strongest;
  const int half = (reach + 1) / 2;
  for (int shift = -1; shift <= 1; ++shift) {
    SumTable<kSums>::Sums near;
    SumTable<kSums>::Sums far;
    int num_near;
    int num_far;
    if (horizontal) {
      const int edge = x + 1 + shift;
      num_near = table_.Sum(edge - reach, y - half, edge, y + half + 1, &near);
      num_far = table_.Sum(edge, y - half, edge + reach, y + half + 1, &far);
    } else {
      const int edge = y + 1 + shift;
      num_near = table_.Sum(x - half, edge - reach, x + half + 1, edge, &near);
      num_far = table_.Sum(x - half, edge, x + half + 1, edge + reach, &far);
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
