// SPDX-License-Identifier: BSD-3-Clause
// Measures how far the picture of a film moves.

#ifndef FREEGS_PHOTOS_PICTURE_MOTION_H_
#define FREEGS_PHOTOS_PICTURE_MOTION_H_

#include <vector>

#include <opencv2/core.hpp>

namespace freegs::photos {

// Follows corners from frame to frame with pyramidal Lucas-Kanade:
//
//   PictureMotion motion(0.01);
//   for (const cv::Mat& grey : frames) path = motion.Add(grey);
//
// A movement is the median distance of the corners from where they were first
// seen. The path grows with the largest movement so far. Once a movement
// exceeds `step`, new corners are taken and the next movement is measured from
// there. So trembling on one spot adds next to nothing. The unit of all lengths
// is the width of the picture. Source: Bouguet, "Pyramidal implementation of
// the Lucas Kanade feature tracker", Intel 2000.
class PictureMotion {
 public:
  explicit PictureMotion(double step) : step_(step) {}

  // Adds the next frame, which is 8-bit grey and as large as the others.
  // Returns the length of the path so far.
  double Add(const cv::Mat& grey);

 private:
  void Restart(const cv::Mat& grey);

  double step_;
  double counted_ = 0;  // Path up to where the corners were first seen.
  double reached_ = 0;  // Path up to now.
  cv::Mat previous_;
  std::vector<cv::Point2f> first_;    // Where the corners were first seen.
  std::vector<cv::Point2f> corners_;  // Where they are now.
  size_t num_first_ = 0;              // How many corners there were at first.
  int lost_ = 0;                      // Frames since they were last found.
};

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PICTURE_MOTION_H_
