// SPDX-License-Identifier: BSD-3-Clause

#include "splat/images/displacement.h"

#include <cmath>

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

}  // namespace

double Displacement(const ImageF& a, const ImageF& b) {
  const cv::Mat grey_a = Grey(a);
  const cv::Mat grey_b = Grey(b);
  cv::Scalar mean, deviation_a, deviation_b;
  cv::meanStdDev(grey_a, mean, deviation_a);
  cv::meanStdDev(grey_b, mean, deviation_b);
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
