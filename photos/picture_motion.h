// SPDX-License-Identifier: BSD-3-Clause
// How far the picture of a film moves.

#ifndef FREEGS_PHOTOS_PICTURE_MOTION_H_
#define FREEGS_PHOTOS_PICTURE_MOTION_H_

#include <vector>

#include <opencv2/core.hpp>

namespace freegs::photos {

// Follows corners from frame to frame (pyramidal Lucas-Kanade) and sums how far
// they get from where they were first seen. A movement counts once it exceeds
// `step`; then new corners are taken. So trembling on one spot adds nothing.
// Lengths are in widths of the picture.
// Source: Bouguet, "Pyramidal implementation of the Lucas Kanade feature
// tracker", Intel 2000.
class PictureMotion {
 public:
  explicit PictureMotion(double step) : step_(step) {}

  // Adds the next frame, 8-bit grey, all of one size. Returns the path so far.
  double Add(const cv::Mat& grey);

 private:
  void Restart(const cv::Mat& grey);

  double step_;
  double counted_ = 0;  // Up to where corners_ were first seen.
  double reached_ = 0;
  cv::Mat previous_;
  std::vector<cv::Point2f> first_;    // Where corners were first seen,
  std::vector<cv::Point2f> corners_;  // and where they are now.
  size_t num_first_ = 0;              // How many there were.
  int lost_ = 0;                      // Frames since they were last found.
};

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PICTURE_MOTION_H_
