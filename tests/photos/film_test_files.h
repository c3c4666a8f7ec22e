// SPDX-License-Identifier: BSD-3-Clause
// Small films for tests.

#ifndef FREEGS_TESTS_PHOTOS_FILM_TEST_FILES_H_
#define FREEGS_TESTS_PHOTOS_FILM_TEST_FILES_H_

#include <filesystem>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "core/random.h"

namespace freegs::photos {

inline constexpr int kFilmWidth = 160;
inline constexpr int kFilmHeight = 120;

// One frame: a wide picture full of corners, seen from pixel `x` on.
inline cv::Mat FilmFrame(double x, bool blurred = false) {
  static const cv::Mat world = [] {
    cv::Mat coarse(kFilmHeight / 6, 200, CV_8UC3);
    for (int i = 0; i < coarse.rows * coarse.cols * 3; ++i) {
      coarse.data[i] = static_cast<uint8_t>(RandomIndex(3, 9, i, 256));
    }
    cv::Mat picture;
    cv::resize(coarse, picture, {1200, kFilmHeight}, 0, 0, cv::INTER_CUBIC);
    return picture;
  }();
  cv::Mat frame;
  cv::getRectSubPix(world,
                    {kFilmWidth, kFilmHeight},
                    cv::Point2f(static_cast<float>(x + kFilmWidth / 2.0),
                                static_cast<float>(kFilmHeight / 2.0)),
                    frame);
  if (blurred) cv::blur(frame, frame, {31, 31});
  return frame;
}

// A film of these frames, all of one size. Motion JPEG in AVI, which OpenCV
// writes by itself.
inline void WriteFilm(const std::filesystem::path& path,
                      const std::vector<cv::Mat>& frames) {
  std::filesystem::create_directories(path.parent_path());
  cv::VideoWriter writer(path.string(),
                         cv::CAP_OPENCV_MJPEG,
                         cv::VideoWriter::fourcc('M', 'J', 'P', 'G'),
                         25,
                         frames.front().size());
  ASSERT_TRUE(writer.isOpened());
  for (const cv::Mat& frame : frames) writer.write(frame);
}

// A film whose picture moves by 4 pixels a frame.
inline std::vector<cv::Mat> MovingFrames(int count, double first = 0) {
  std::vector<cv::Mat> frames;
  for (int i = 0; i < count; ++i) frames.push_back(FilmFrame(first + 4 * i));
  return frames;
}

}  // namespace freegs::photos

#endif  // FREEGS_TESTS_PHOTOS_FILM_TEST_FILES_H_
