// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/features/sift.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/area_average.h"
#include "core/io/image_io.h"

namespace freegs::sfm {
namespace {

// Lowe's values, apart from the least contrast. With 0.012 plain things have as
// many features as by COLMAP. Its own least contrast, 0.02, gives fewer here,
// because OpenCV blurs a little when it doubles an image.
constexpr int kLayersPerOctave = 3;
constexpr double kMinContrast = 0.012;
constexpr double kMaxEdgeRatio = 10;
constexpr double kFirstBlur = 1.6;

// Features of larger scale are left out, as by COLMAP. Their positions are
// least exact, and an adjustment of the cameras takes all for equally exact.
constexpr float kMaxScale = 14;

// OpenCV doubles the sides of the image first, which keeps the corners of the
// image in place, but halves positions as if it had kept the centre of the
// first pixel. So they are a quarter of a pixel too large. They are also
// counted from that centre, and ours from the corner, which is half a pixel
// more.
constexpr float kShift = 0.25f;

constexpr float kDescriptorLength = 512;

// OpenCV's size is a diameter of twice the scale.
float ScaleOf(const cv::KeyPoint& keypoint) { return keypoint.size / 2; }

// Square roots of the shares of the sum, as bytes.
void AppendRootSift(const float* values, std::vector<uint8_t>* bytes) {
  float sum = 0;
  for (size_t i = 0; i < kSiftDimensions; ++i) sum += values[i];
  const float scale = sum > 0 ? 1 / sum : 0;
  for (size_t i = 0; i < kSiftDimensions; ++i) {
    const float root = kDescriptorLength * std::sqrt(values[i] * scale);
    bytes->push_back(static_cast<uint8_t>(std::min(std::round(root), 255.0f)));
  }
}

// Whether a mask is 0 at a keypoint of an image of this size.
bool IsMasked(const ImageU16& mask,
              const cv::KeyPoint& keypoint,
              int width,
              int height) {
  if (mask.empty()) return false;
  const auto pixel = [](float position, int side, int pixels) {
    const double share = (position + kShift) / side;
    return std::clamp(static_cast<int>(share * pixels), 0, pixels - 1);
  };
  return mask(pixel(keypoint.pt.x, width, mask.width()),
              pixel(keypoint.pt.y, height, mask.height())) == 0;
}

// The numbers of the max_features largest of these keypoints, which are in
// `order`, the largest first.
std::vector<size_t> LargestFirst(const std::vector<cv::KeyPoint>& keypoints,
                                 std::vector<size_t> order,
                                 int max_features) {
  // OpenCV sorts its keypoints, so that their order is always the same.
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return keypoints[a].size > keypoints[b].size;
  });
  order.resize(std::min(order.size(), static_cast<size_t>(max_features)));
  return order;
}

ImageU8 Shrink(ImageU8 image, int max_image_size) {
  const int longest = std::max(image.width(), image.height());
  if (longest <= max_image_size) return image;
  const auto side = [&](int pixels) {
    const double scaled = static_cast<double>(pixels) * max_image_size;
    return std::max(1, static_cast<int>(std::lround(scaled / longest)));
  };
  return AreaAverage(image, side(image.width()), side(image.height()));
}

}  // namespace

SiftFeatures FindSift(const ImageU8& rgb,
                      int max_features,
                      const ImageU16& mask) {
  SiftFeatures features;
  if (rgb.empty()) return features;
  cv::Mat grey;
  cv::cvtColor(
      cv::Mat(
          rgb.height(), rgb.width(), CV_8UC3, const_cast<uint8_t*>(rgb.data())),
      grey,
      cv::COLOR_RGB2GRAY);
  std::vector<cv::KeyPoint> found;
  cv::Mat descriptors;
  cv::SIFT::create(0, kLayersPerOctave, kMinContrast, kMaxEdgeRatio, kFirstBlur)
      ->detectAndCompute(grey, cv::noArray(), found, descriptors);
  std::vector<size_t> wanted;
  for (size_t i = 0; i < found.size(); ++i) {
    if (ScaleOf(found[i]) <= kMaxScale &&
        !IsMasked(mask, found[i], rgb.width(), rgb.height())) {
      wanted.push_back(i);
    }
  }
  const std::vector<size_t> order =
      LargestFirst(found, std::move(wanted), max_features);
  features.keypoints.reserve(order.size());
  features.descriptors.values.reserve(order.size() * kSiftDimensions);
  constexpr auto kRadians = static_cast<float>(CV_PI / 180);
  for (const size_t i : order) {
    features.keypoints.push_back({found[i].pt.x + kShift,
                                  found[i].pt.y + kShift,
                                  ScaleOf(found[i]),
                                  found[i].angle * kRadians});
    AppendRootSift(descriptors.ptr<float>(static_cast<int>(i)),
                   &features.descriptors.values);
  }
  return features;
}

StatusOr<SiftFeatures> FindPhotoSift(const std::filesystem::path& photo,
                                     const std::filesystem::path& mask,
                                     int max_image_size,
                                     int max_features) {
  FREEGS_ASSIGN_OR_RETURN(ImageU8 image, ReadRgb(photo));
  const int width = image.width();
  const int height = image.height();
  image = Shrink(std::move(image), max_image_size);
  ImageU16 wanted;
  if (!mask.empty()) {
    FREEGS_ASSIGN_OR_RETURN(wanted, ReadLabels(mask));
  }
  SiftFeatures features = FindSift(image, max_features, wanted);
  const float scale_x = static_cast<float>(width) / image.width();
  const float scale_y = static_cast<float>(height) / image.height();
  for (Keypoint& keypoint : features.keypoints) {
    keypoint.x *= scale_x;
    keypoint.y *= scale_y;
    keypoint.scale *= std::sqrt(scale_x * scale_y);
  }
  return features;
}

OneOpenCvThread::OneOpenCvThread() : before_(cv::getNumThreads()) {
  cv::setNumThreads(1);
}

OneOpenCvThread::~OneOpenCvThread() { cv::setNumThreads(before_); }

}  // namespace freegs::sfm
