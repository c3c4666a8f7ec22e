// SPDX-License-Identifier: BSD-3-Clause

#include "photos/picture_motion.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "core/quantile.h"

namespace freegs::photos {
namespace {

constexpr int kNumCorners = 200;
constexpr double kCornerQuality = 0.01;  // Share of the best corner's.
constexpr double kCornerDistance = 8;    // Pixels.
constexpr size_t kMinCorners = 8;
constexpr double kMaxReturnError = 1;  // Pixels.
constexpr int kMaxLost = 5;            // Frames.

}  // namespace

void PictureMotion::Restart(const cv::Mat& grey) {
  first_.clear();
  cv::goodFeaturesToTrack(
      grey, first_, kNumCorners, kCornerQuality, kCornerDistance);
  corners_ = first_;
  num_first_ = first_.size();
  lost_ = 0;
}

double PictureMotion::Add(const cv::Mat& grey) {
  if (previous_.empty() || num_first_ < kMinCorners) {
    // Nothing to follow: whether the picture moves cannot be seen.
    Restart(grey);
    grey.copyTo(previous_);
    return reached_;
  }
  std::vector<cv::Point2f> next;
  std::vector<cv::Point2f> back;
  std::vector<uint8_t> found;
  std::vector<uint8_t> found_back;
  std::vector<float> error;
  const cv::Size window(15, 15);
  cv::calcOpticalFlowPyrLK(
      previous_, grey, corners_, next, found, error, window, 3);
  cv::calcOpticalFlowPyrLK(
      grey, previous_, next, back, found_back, error, window, 3);
  const cv::Rect2f inside(
      0, 0, static_cast<float>(grey.cols), static_cast<float>(grey.rows));
  std::vector<double> lengths;
  std::vector<size_t> kept;
  for (size_t i = 0; i < next.size(); ++i) {
    // A corner that is found again leads back to where it came from.
    if (found[i] == 0 || found_back[i] == 0 || !inside.contains(next[i]) ||
        cv::norm(back[i] - corners_[i]) > kMaxReturnError) {
      continue;
    }
    const cv::Point2f moved = next[i] - first_[i];
    lengths.push_back(std::hypot(moved.x, moved.y) / grey.cols);
    kept.push_back(i);
  }
  if (kept.size() < kMinCorners) {
    // A blurred frame is passed over; after several, or a cut, it goes on from
    // here, and nobody knows how far that is.
    if (++lost_ <= kMaxLost) return reached_;
    reached_ += step_;
    counted_ = reached_;
    Restart(grey);
    grey.copyTo(previous_);
    return reached_;
  }
  lost_ = 0;
  for (size_t k = 0; k < kept.size(); ++k) {
    first_[k] = first_[kept[k]];
    corners_[k] = next[kept[k]];
  }
  first_.resize(kept.size());
  corners_.resize(kept.size());
  grey.copyTo(previous_);
  const double moved = UpperMedian(std::move(lengths));
  reached_ = std::max(reached_, counted_ + moved);
  if (moved >= step_ || 2 * kept.size() < num_first_) {
    counted_ += moved;
    Restart(grey);
  }
  return reached_;
}

}  // namespace freegs::photos
