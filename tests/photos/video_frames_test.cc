// SPDX-License-Identifier: BSD-3-Clause
// Frames of films: which are taken, and what happens to damaged films.

#include "photos/video_frames.h"

#include <algorithm>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/files.h"
#include "photos/film_rotation.h"
#include "photos/photo_pixels.h"
#include "tests/photos/film_test_files.h"
#include "tests/temporary_folder.h"

namespace freegs::photos {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class VideoFramesTest : public testing::Test {
 protected:
  VideoFramesTest() { options_.min_frames = 3; }

  StatusOr<VideoSurvey> Survey(const std::string& name) const {
    return SurveyVideo(folder_ / name, options_, {}, nullptr);
  }

  // The frames chosen from a film of these frames.
  std::vector<VideoFrame> Choose(const std::vector<cv::Mat>& frames) const {
    WriteFilm(folder_ / "film.avi", frames);
    const auto survey = Survey("film.avi");
    EXPECT_TRUE(survey.ok()) << survey.status().message();
    if (!survey.ok()) return {};
    EXPECT_EQ(survey->frames.size(), frames.size());
    return ChooseVideoFrames(survey->frames, options_);
  }

  TemporaryFolder folder_;
  VideoFrameOptions options_;
};

TEST_F(VideoFramesTest, PathFollowsThePicture) {
  WriteFilm(folder_ / "film.avi", MovingFrames(60));
  const auto survey = Survey("film.avi");
  ASSERT_TRUE(survey.ok()) << survey.status().message();
  EXPECT_EQ(survey->width, kFilmWidth);
  EXPECT_EQ(survey->height, kFilmHeight);
  EXPECT_EQ(survey->claimed_frames, 60);
  // 59 steps of 4 pixels.
  EXPECT_NEAR(survey->frames.back().path, 59.0 * 4 / kFilmWidth, 0.08);
  for (size_t i = 1; i < survey->frames.size(); ++i) {
    EXPECT_GE(survey->frames[i].path, survey->frames[i - 1].path);
    EXPECT_EQ(survey->frames[i].number, static_cast<int>(i));
    EXPECT_NEAR(survey->frames[i].time_s, static_cast<double>(i) / 25, 0.05);
  }
  // A second survey finds the same.
  const auto again = Survey("film.avi");
  for (size_t i = 0; i < survey->frames.size(); ++i) {
    EXPECT_EQ(again->frames[i].path, survey->frames[i].path);
    EXPECT_EQ(again->frames[i].sharpness, survey->frames[i].sharpness);
  }
}

TEST_F(VideoFramesTest, FewFramesFromAStaticStretch) {
  std::vector<cv::Mat> frames = MovingFrames(30);
  for (int i = 0; i < 100; ++i) {
    // A hand that trembles by a third of a pixel.
    frames.push_back(FilmFrame(4 * 29 + (i % 2 == 0 ? 0.3 : 0)));
  }
  const std::vector<cv::Mat> rest = MovingFrames(30, 4 * 30);
  frames.insert(frames.end(), rest.begin(), rest.end());
  const std::vector<VideoFrame> chosen = Choose(frames);
  // 59 moves of 4 pixels are 1.5 widths: some 30 stretches of 0.05.
  EXPECT_GE(chosen.size(), 24u);
  EXPECT_LE(chosen.size(), 33u);
  const auto resting =
      std::count_if(chosen.begin(), chosen.end(), [](const VideoFrame& frame) {
        return frame.number >= 30 && frame.number < 130;
      });
  EXPECT_LE(resting, 2);
  for (size_t i = 1; i < chosen.size(); ++i) {
    EXPECT_GT(chosen[i].number, chosen[i - 1].number);
    EXPECT_LT(chosen[i].path - chosen[i - 1].path, 0.11);
  }
}

TEST_F(VideoFramesTest, BlurredFramesAreAvoided) {
  std::vector<cv::Mat> frames;
  const auto is_blurred = [](int i) {
    // Every other one, and a whole stretch.
    return i % 2 == 1 || (i >= 40 && i < 60);
  };
  for (int i = 0; i < 100; ++i) {
    frames.push_back(FilmFrame(4 * i, is_blurred(i)));
  }
  const std::vector<VideoFrame> chosen = Choose(frames);
  EXPECT_GE(chosen.size(), 15u);
  for (const VideoFrame& frame : chosen) {
    EXPECT_FALSE(is_blurred(frame.number)) << frame.number;
  }
}

TEST_F(VideoFramesTest, FilmsWithoutMovementGiveOneFrame) {
  EXPECT_EQ(Choose(std::vector<cv::Mat>(50, FilmFrame(0))).size(), 1u);
  const cv::Mat black(kFilmHeight, kFilmWidth, CV_8UC3, cv::Scalar(0, 0, 0));
  EXPECT_EQ(Choose(std::vector<cv::Mat>(50, black)).size(), 1u);
}

TEST_F(VideoFramesTest, ChosenFramesAreRead) {
  const std::vector<VideoFrame> chosen = Choose(MovingFrames(40));
  size_t next = 0;
  const Status status = ReadVideoFrames(
      folder_ / "film.avi",
      chosen,
      [&](const VideoFrame& frame, const ImageU8& pixels) {
        EXPECT_EQ(frame.number, chosen[next].number);
        EXPECT_EQ(Sharpness(pixels), chosen[next].sharpness);
        ++next;
        return Status();
      },
      nullptr);
  EXPECT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(next, chosen.size());

  std::vector<VideoFrame> missing = chosen;
  missing.back().number = 1000;
  EXPECT_EQ(ReadVideoFrames(
                folder_ / "film.avi",
                missing,
                [](const auto&, const auto&) { return Status(); },
                nullptr)
                .code(),
            StatusCode::kBadInput);
}

TEST_F(VideoFramesTest, CancellationStops) {
  WriteFilm(folder_ / "film.avi", MovingFrames(20));
  CancellationToken token;
  token.Cancel();
  EXPECT_EQ(
      SurveyVideo(folder_ / "film.avi", options_, {}, &token).status().code(),
      StatusCode::kInterrupted);
}

TEST_F(VideoFramesTest, DamagedFilms) {
  WriteFilm(folder_ / "film.avi", MovingFrames(40));
  const std::string film = *ReadFile(folder_ / "film.avi");
  // The index at the end is lost, and half of the frames.
  WriteText(folder_ / "half.avi", film.substr(0, film.size() / 2));
  const auto half = Survey("half.avi");
  ASSERT_TRUE(half.ok()) << half.status().message();
  EXPECT_LT(half->frames.size(), 30u);
  EXPECT_GT(half->frames.size(), 10u);

  // Sizes in the main header and in the format of the stream.
  std::string huge = film;
  const std::string side("\x60\xea\0\0", 4);  // 60000.
  huge.replace(huge.find("avih") + 8 + 32, 8, side + side);
  huge.replace(huge.find("strf") + 8 + 4, 8, side + side);
  const size_t frames = film.find("movi") + 4;
  const struct {
    std::string bytes;
    const char* message;
  } cases[] = {
      {"", "empty file"},
      {"this is a text that is called a film\n", "not a film"},
      {"#EXTM3U\nhttp://example.com/a.ts\n", "not a film"},
      {film.substr(0, 100), ""},
      {film.substr(0, frames), ""},  // No frame.
      {film.substr(0, frames) + std::string(5000, '\x7f'), ""},
      {std::string("\0\0\0\x18", 4) + "ftypmp42" + std::string(500, '\0'), ""},
      {std::string("\x1a\x45\xdf\xa3", 4) + std::string(500, '\xff'), ""},
  };
  for (const auto& test : cases) {
    WriteText(folder_ / "bad.avi", test.bytes);
    const auto survey = Survey("bad.avi");
    ASSERT_FALSE(survey.ok()) << test.bytes.size();
    EXPECT_EQ(survey.status().code(), StatusCode::kBadInput);
    EXPECT_THAT(survey.status().message(), HasSubstr("bad.avi: "));
    EXPECT_THAT(survey.status().message(), HasSubstr(test.message));
  }
  EXPECT_EQ(Survey("missing.avi").status().code(), StatusCode::kBadInput);
  fs::create_directory(folder_ / "folder.avi");
  EXPECT_EQ(Survey("folder.avi").status().code(), StatusCode::kBadInput);

  // Either refused, or read as what the frames themselves say.
  WriteText(folder_ / "huge.avi", huge);
  const auto read = Survey("huge.avi");
  if (read.ok()) {
    EXPECT_EQ(read->width, kFilmWidth);
  } else {
    EXPECT_EQ(read.status().code(), StatusCode::kBadInput);
    EXPECT_THAT(read.status().message(), HasSubstr("more than the limit"));
  }
  options_.max_megapixels = 0.01;
  EXPECT_THAT(Survey("film.avi").status().message(),
              HasSubstr("more than the limit of 0.01"));
  options_.max_megapixels_option = "ingest.max_megapixels";
  EXPECT_THAT(Survey("film.avi").status().message(),
              HasSubstr("(ingest.max_megapixels)"));
  for (const double limit : {0.0, -1.0, std::nan("")}) {
    options_.max_megapixels = limit;
    EXPECT_EQ(options_.Check().code(), StatusCode::kInvalidArgument);
  }
}

TEST_F(VideoFramesTest, RotationIsRespected) {
  const fs::path path = folder_ / "film.mp4";
  {
    cv::VideoWriter writer(path.string(),
                           cv::CAP_FFMPEG,
                           cv::VideoWriter::fourcc('m', 'p', '4', 'v'),
                           25,
                           {kFilmWidth, kFilmHeight});
    if (!writer.isOpened()) GTEST_SKIP() << "cannot write MPEG-4";
    cv::Mat frame(kFilmHeight, kFilmWidth, CV_8UC3, cv::Scalar(0, 0, 0));
    frame.colRange(0, kFilmWidth / 2).setTo(cv::Scalar(255, 255, 255));
    for (int i = 0; i < 10; ++i) writer.write(frame);
  }
  // The matrix of the track header (ISO 14496-12, 8.3.2): a quarter turn
  // clockwise instead of the identity.
  std::string film = *ReadFile(path);
  const size_t matrix = film.find("tkhd") + 4 + 40;
  ASSERT_EQ(film.substr(matrix, 4), std::string("\0\1\0\0", 4));
  const std::string one("\0\1\0\0", 4);
  const std::string minus_one("\xff\xff\0\0", 4);
  const std::string zero(4, '\0');
  film.replace(matrix, 20, zero + one + zero + minus_one + zero);
  WriteText(path, film);
  EXPECT_EQ(FilmRotation(path), 90);
  // Damaged headers end the search.
  const std::string moov = film.substr(film.find("moov") + 4);
  EXPECT_EQ(MovieRotation(moov), 90);
  for (size_t size = 0; size < moov.size(); ++size) {
    const int rotation = MovieRotation(moov.substr(0, size));
    EXPECT_TRUE(rotation == 0 || rotation == 90);
    std::string damaged = moov;
    damaged[size] = static_cast<char>(damaged[size] ^ 0xff);
    EXPECT_EQ(MovieRotation(damaged) % 90, 0);
  }
  const auto survey = Survey("film.mp4");
  ASSERT_TRUE(survey.ok()) << survey.status().message();
  EXPECT_EQ(survey->width, kFilmHeight);
  EXPECT_EQ(survey->height, kFilmWidth);
  const Status status = ReadVideoFrames(
      path,
      {survey->frames[3]},
      [](const VideoFrame&, const ImageU8& pixels) {
        // What was on the left is on top.
        EXPECT_GT(pixels(60, 20, 0), 200);
        EXPECT_LT(pixels(60, 140, 0), 50);
        return Status();
      },
      nullptr);
  EXPECT_TRUE(status.ok()) << status.message();
}

TEST(ChooseVideoFrames, BoundsAndSharpest) {
  std::vector<VideoFrame> frames;
  for (int i = 0; i < 1000; ++i) {
    VideoFrame frame;
    frame.number = i;
    frame.path = i * 0.01;
    frame.sharpness = i % 7 == 3 ? 200 : 100;
    frames.push_back(frame);
  }
  VideoFrameOptions options;
  // 10 widths: 200 stretches of 5 frames each.
  EXPECT_NEAR(
      static_cast<double>(ChooseVideoFrames(frames, options).size()), 200, 2);
  options.max_frames = 50;
  const std::vector<VideoFrame> few = ChooseVideoFrames(frames, options);
  EXPECT_EQ(few.size(), 50u);
  for (const VideoFrame& frame : few) EXPECT_EQ(frame.sharpness, 200);
  options.motion = 1;
  options.min_frames = 30;
  EXPECT_EQ(ChooseVideoFrames(frames, options).size(), 30u);
  options.max_frames = 20;
  EXPECT_EQ(ChooseVideoFrames(frames, options).size(), 20u);
  EXPECT_TRUE(ChooseVideoFrames({}, options).empty());
}

TEST(VideoFrameOptions, CheckRefusesValuesOutOfRange) {
  VideoFrameOptions options;
  EXPECT_TRUE(options.Check().ok());
  options.motion = 0;
  EXPECT_FALSE(options.Check().ok());
  options = VideoFrameOptions();
  options.max_frames = 10;  // Less than min_frames: it is the bound of both.
  EXPECT_TRUE(options.Check().ok());
  options.max_frames = 2;
  EXPECT_FALSE(options.Check().ok());
}

TEST(LooksLikeVideo, KnowsTheKinds) {
  EXPECT_TRUE(LooksLikeVideo(std::string("\0\0\0\x18", 4) + "ftypisom"));
  EXPECT_TRUE(LooksLikeVideo("RIFF1234AVI LIST"));
  EXPECT_FALSE(LooksLikeVideo("RIFF1234WEBPVP8 "));
  EXPECT_FALSE(LooksLikeVideo(""));
  EXPECT_FALSE(LooksLikeVideo("G"));
  std::string stream(400, '\0');
  stream[0] = stream[188] = 'G';
  EXPECT_TRUE(LooksLikeVideo(stream));
}

}  // namespace
}  // namespace freegs::photos
