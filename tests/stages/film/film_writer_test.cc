// SPDX-License-Identifier: BSD-3-Clause

#include "stages/film/film_writer.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/videoio.hpp>

#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

using testing::HasSubstr;

ImageU8 PlainPicture(int width, int height, uint8_t red) {
  ImageU8 picture(width, height, 3);
  for (size_t k = 0; k < picture.num_pixels(); ++k) {
    picture.data()[3 * k] = red;
    picture.data()[3 * k + 1] = 60;
    picture.data()[3 * k + 2] = 20;
  }
  return picture;
}

TEST(FilmWriterTest, ReadsBack) {
  const TemporaryFolder folder;
  const auto path = folder / "film.mp4";
  auto film = FilmWriter::Open(path, 64, 48, 25);
  ASSERT_TRUE(film.ok()) << film.status().message();
  for (int k = 0; k < 12; ++k) {
    ASSERT_TRUE((*film)
                    ->Write(PlainPicture(64, 48, static_cast<uint8_t>(15 * k)))
                    .ok());
  }
  EXPECT_FALSE((*film)->Write(PlainPicture(62, 48, 0)).ok());
  EXPECT_FALSE(std::filesystem::exists(path));
  const Status closed = (*film)->Close();
  ASSERT_TRUE(closed.ok()) << closed.message();
  cv::VideoCapture capture(path.string());
  ASSERT_TRUE(capture.isOpened());
  EXPECT_EQ(capture.get(cv::CAP_PROP_FPS), 25);
  cv::Mat bgr;
  int count = 0;
  for (; capture.read(bgr); ++count) {
    ASSERT_EQ(bgr.size(), cv::Size(64, 48));
    EXPECT_NEAR(bgr.at<cv::Vec3b>(20, 30)[2], 15 * count, 8);
    EXPECT_NEAR(bgr.at<cv::Vec3b>(20, 30)[0], 20, 8);
  }
  EXPECT_EQ(count, 12);
}

TEST(FilmWriterTest, LimitsOfTheFormat) {
  const TemporaryFolder folder;
  const Status wide =
      FilmWriter::Open(folder / "film.mp4", 8194, 16, 30).status();
  EXPECT_EQ(wide.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(wide.message(), testing::HasSubstr("--size"));
  // A rate that is no fraction of small numbers.
  auto film = FilmWriter::Open(folder / "film.mp4", 32, 24, 119.881);
  ASSERT_TRUE(film.ok()) << film.status().message();
  ASSERT_TRUE((*film)->Write(PlainPicture(32, 24, 0)).ok());
  EXPECT_TRUE((*film)->Close().ok());
}

TEST(FilmWriterTest, NothingIsLeftWithoutClose) {
  const TemporaryFolder folder;
  {
    auto film = FilmWriter::Open(folder / "film.mp4", 64, 48, 25);
    ASSERT_TRUE(film.ok());
    ASSERT_TRUE((*film)->Write(PlainPicture(64, 48, 0)).ok());
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(FilmWriterTest, ClearErrors) {
  const TemporaryFolder folder;
  EXPECT_EQ(CheckFilmPath(folder / "film.gif").code(),
            StatusCode::kInvalidArgument);
  EXPECT_EQ(FilmWriter::Open(folder / "f.mp4", 63, 48, 25).status().code(),
            StatusCode::kInvalidArgument);
  const Status status =
      FilmWriter::Open(folder / "none" / "f.mp4", 64, 48, 25).status();
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("f.mp4"));
}

}  // namespace
}  // namespace freegs::stages
