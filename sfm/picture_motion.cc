// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/picture_motion.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace freegs::sfm {
namespace {

constexpr int kNumCorners = 200;
constexpr double kCornerQuality = 0.01;  // Of the best corner's.
constexpr double kCornerDistance = 8;    // Pixels.
constexpr size_t kMinCorners = 8;

}  // namespace

void PictureMotion::Restart(const cv::Mat& grey) {
  first_.clear();
  cv::goodFeaturesToTrack(
      grey, first_, kNumCorners, kCornerQuality, kCornerDistance);
  corners_ = first_;
  num_first_ = first_.size();
}

double PictureMotion::Add(const cv::Mat& grey) {
  if (previous_.empty() || num_first_ < kMinCorners) {
    // Nothing to follow: whether the picture moves cannot be seen.
    Restart(grey);
    grey.copyTo(previous_);
    return reached_;
  }
  std::vector<cv::Point2f> next;
  std::vector<uint8_t> found;
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(
      previous_, grey, corners_, next, found, error, cv::Size(15, 15), 3);
  const cv::Rect2f inside(
      0, 0, static_cast<float>(grey.cols), static_cast<float>(grey.rows));
  std::vector<double> lengths;
  size_t kept = 0;
  for (size_t i = 0; i < next.size(); ++i) {
    if (found[i] == 0 || !inside.contains(next[i])) continue;
    first_[kept] = first_[i];
    corners_[kept] = next[i];
    const cv::Point2f moved = next[i] - first_[i];
    lengths.push_back(std::hypot(moved.x, moved.y) / grey.cols);
    ++kept;
  }
  first_.resize(kept);
  corners_.resize(kept);
  grey.copyTo(previous_);
  if (kept < kMinCorners) {
    // Lost, by blur or a cut: so far, and nobody knows how far.
    counted_ = std::max(reached_, counted_) + step_;
    reached_ = counted_;
    Restart(grey);
    return reached_;
  }
  std::nth_element(lengths.begin(), lengths.begin() + kept / 2, lengths.end());
  const double moved = lengths[kept / 2];
  reached_ = std::max(reached_, counted_ + moved);
  if (moved >= step_ || 2 * kept < num_first_) {
    counted_ += moved;
    Restart(grey);
  }
  return reached_;
}

}  // namespace freegs::sfm
