// SPDX-License-Identifier: BSD-3-Clause

#include "splat/images/displacement.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace freegs::splat {
namespace {

cv::Mat Grey(const ImageF& image) {
  // OpenCV's matrices of memory that is only read are not const.
  const cv::Mat rgb(image.height(),
                    image.width(),
                    CV_32FC3,
                    const_cast<float*>(image.data()));
  cv::Mat grey;
  cv::cvtColor(rgb, grey, cv::COLOR_RGB2GRAY);
  return grey;
}

// A matrix of the mask's memory, which is only read; empty without a mask.
cv::Mat UsedPixels(const ImageU8* mask) {
  if (mask == nullptr) return {};
  return {
      mask->height(), mask->width(), CV_8U, const_cast<uint8_t*>(mask->data())};
}

}  // namespace

double Displacement(const ImageF& a, const ImageF& b, const ImageU8* mask) {
  // A window that falls to the borders needs more.
  if (std::min(a.width(), a.height()) < 2) return 0;
  cv::Mat grey_a = Grey(a);
  cv::Mat grey_b = Grey(b);
  const cv::Mat used = UsedPixels(mask);
  cv::Scalar mean_a, mean_b, deviation_a, deviation_b;
  cv::meanStdDev(grey_a, mean_a, deviation_a, used);
  cv::meanStdDev(grey_b, mean_b, deviation_b, used);
  if (mask != nullptr) {
    grey_a.setTo(mean_a, used == 0);
    grey_b.setTo(mean_b, used == 0);
  }
  // Less than a step of 8 bits everywhere.
  constexpr double kFlat = 1 / 255.0;
  if (deviation_a[0] < kFlat || deviation_b[0] < kFlat) return 0;
  cv::Mat window;
  cv::createHanningWindow(window, grey_a.size(), CV_32F);
  const cv::Point2d shift = cv::phaseCorrelate(grey_a, grey_b, window);
  const double length = std::hypot(shift.x, shift.y);
  return std::isfinite(length) ? length : 0;
}

}  // namespace freegs::splat
