// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_pixels.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <opencv2/imgproc.hpp>

#include "core/io/files.h"

namespace freegs::photos {
namespace {

constexpr int kSharpnessSide = 512;

// A view of the image's memory; OpenCV has no constant one.
cv::Mat AsMat(const ImageU8& image) {
  return cv::Mat(image.height(),
                 image.width(),
                 CV_8UC(image.channels()),
                 const_cast<uint8_t*>(image.data()));
}

}  // namespace

ImageU8 Upright(const ImageU8& image, int orientation) {
  if (orientation <= 1 || orientation > 8) return image;
  const bool transposed = orientation >= 5;
  ImageU8 upright(transposed ? image.height() : image.width(),
                  transposed ? image.width() : image.height(),
                  image.channels());
  const cv::Mat source = AsMat(image);
  cv::Mat target = AsMat(upright);
  if (transposed) cv::transpose(source, target);
  const cv::Mat& turned = transposed ? target : source;
  switch (orientation) {
    case 2:  // Mirrored left to right.
    case 6:  // Turned by 90 degrees anticlockwise.
      cv::flip(turned, target, 1);
      break;
    case 3:  // Turned by 180 degrees.
    case 7:  // Transposed about the other diagonal.
      cv::flip(turned, target, -1);
      break;
    case 4:  // Mirrored top to bottom.
    case 8:  // Turned by 90 degrees clockwise.
      cv::flip(turned, target, 0);
      break;
    default:  // 5, transposed.
      break;
  }
  return upright;
}

double Sharpness(const ImageU8& rgb) {
  cv::Mat grey;
  cv::cvtColor(AsMat(rgb), grey, cv::COLOR_RGB2GRAY);
  const int side = std::max(grey.cols, grey.rows);
  if (side > kSharpnessSide) {
    const double scale = static_cast<double>(kSharpnessSide) / side;
    const cv::Size size(
        std::max(1, static_cast<int>(std::lround(grey.cols * scale))),
        std::max(1, static_cast<int>(std::lround(grey.rows * scale))));
    cv::Mat reduced;
    cv::resize(grey, reduced, size, 0, 0, cv::INTER_AREA);
    grey = reduced;
  }
  cv::Mat laplacian;
  cv::Laplacian(grey, laplacian, CV_32F, 1);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(laplacian, mean, deviation);
  return deviation[0] * deviation[0];
}

std::string ContentHash(const ImageU8& image) {
  const std::string_view pixels(reinterpret_cast<const char*>(image.data()),
                                image.size());
  return HashBytes(std::to_string(image.width()) + "x" +
                   std::to_string(image.height()) + "x" +
                   std::to_string(image.channels()) + " " + HashBytes(pixels));
}

}  // namespace freegs::photos
