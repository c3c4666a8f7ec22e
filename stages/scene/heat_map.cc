// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/heat_map.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace freegs::stages {

ColorScale InfernoScale() {
  cv::Mat ramp(1, 256, CV_8UC1);
  for (int i = 0; i < 256; ++i) {
    ramp.at<uint8_t>(0, i) = static_cast<uint8_t>(i);
  }
  cv::Mat bgr;
  cv::applyColorMap(ramp, bgr, cv::COLORMAP_INFERNO);
  ColorScale scale;
  for (int i = 0; i < 256; ++i) {
    const cv::Vec3b& entry = bgr.at<cv::Vec3b>(0, i);
    scale[static_cast<size_t>(i)] = {entry[2], entry[1], entry[0]};
  }
  return scale;
}

ImageU8 HeatMap(const ImageU8& picture,
                const ImageF& values,
                double low,
                double high) {
  const ColorScale inferno = InfernoScale();
  ImageU8 heat(picture.width(), picture.height(), 3);
  for (size_t k = 0; k < picture.num_pixels(); ++k) {
    const uint8_t* pixel = picture.data() + 3 * k;
    const double grey = 0.299 * pixel[0] + 0.587 * pixel[1] + 0.114 * pixel[2];
    const double share =
        std::clamp((values.data()[k] - low) / (high - low), 0.0, 1.0);
    const std::array<uint8_t, 3>& color =
        inferno[static_cast<size_t>(std::lround(255 * share))];
    // The picture always shines through, so that one sees what is hot.
    const double opacity = 0.8 * std::sqrt(share);
    for (size_t c = 0; c < 3; ++c) {
      heat.data()[3 * k + c] = static_cast<uint8_t>(
          std::lround((1 - opacity) * 0.6 * grey + opacity * color[c]));
    }
  }
  return heat;
}

}  // namespace freegs::stages
