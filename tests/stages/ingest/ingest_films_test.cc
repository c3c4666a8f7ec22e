// SPDX-License-Identifier: BSD-3-Clause

#include "stages/ingest/ingest_films.h"

#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/files.h"
#include "tests/photos/film_test_files.h"
#include "tests/stages/ingest_test_fixture.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using photos::Photo;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

using IngestFilmsTest = IngestTestFixture;

TEST_F(IngestFilmsTest, FilmInsteadOfAFolder) {
  photos::WriteFilm(images_.path() / "my film.avi", photos::MovingFrames(50));
  source_ = images_.path() / "my film.avi";
  const Status status = Run();
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_THAT(warnings_, IsEmpty());
  const photos::PhotoList list = List();
  EXPECT_GE(list.photos.size(), 20U);
  EXPECT_LT(list.photos.size(), 40U);
  int last = -1;
  for (const Photo& photo : list.photos) {
    EXPECT_EQ(photo.film, "my film.avi");
    EXPECT_GT(photo.frame, last);
    last = photo.frame;
    EXPECT_NEAR(photo.time_s, photo.frame / 25.0, 0.05);
    EXPECT_THAT(photo.file, testing::StartsWith("my film.avi/frame_0000"));
    EXPECT_THAT(photo.name, testing::StartsWith("my_film.avi/frame_0000"));
    EXPECT_EQ(photo.width, photos::kFilmWidth);
  }
  EXPECT_EQ(Written().size(), list.photos.size());
  EXPECT_FALSE(fs::exists(workspace_.path() / "ingest.partial/frames"));
  // The bytes are the same again, and with another number of threads.
  const std::string first =
      *ReadFile(workspace_.path() / "ingest.partial/images.json");
  ASSERT_TRUE(Run(1).ok());
  EXPECT_EQ(*ReadFile(workspace_.path() / "ingest.partial/images.json"), first);
}

TEST_F(IngestFilmsTest, TooFewFramesForTheWayOfAFilmAreTold) {
  photos::WriteFilm(images_.path() / "a.avi", photos::MovingFrames(50));
  options_.film.max_frames = 4;
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(warnings_,
              ElementsAre(AllOf(HasSubstr("a.avi: between "),
                                HasSubstr("--ingest.video_frames"))));
  options_.film.max_frames = 300;
  options_.film.min_frames = 3;
  options_.film.motion = 0.5;
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("--ingest.video_motion")));
}

TEST_F(IngestFilmsTest, AStretchWithoutASharpFrameIsTold) {
  std::vector<cv::Mat> frames = photos::MovingFrames(60);
  for (size_t i = 20; i < 40; ++i) {
    cv::GaussianBlur(frames[i], frames[i], {}, 12);
  }
  photos::WriteFilm(images_.path() / "a.avi", frames);
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("are blurred")));
}

TEST_F(IngestFilmsTest, FolderOfFilms) {
  photos::WriteFilm(images_.path() / "a.avi", photos::MovingFrames(30));
  photos::WriteFilm(images_.path() / "b.avi", photos::MovingFrames(30, 400));
  images_.Write("c.mp4", "no film");
  ASSERT_TRUE(Run().ok());
  const photos::PhotoList list = List();
  EXPECT_EQ(list.photos.front().film, "a.avi");
  EXPECT_EQ(list.photos.back().file, "c.mp4");
  EXPECT_FALSE(list.photos.back().usable());
  EXPECT_EQ(summary_["camera_groups"], 2);
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("c.mp4: not used: ")));
}

TEST_F(IngestFilmsTest, FilmsAmongPhotosAreNamed) {
  WritePhotos(3);
  photos::WriteFilm(images_.path() / "a.avi", photos::MovingFrames(30));
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(List().photos.size(), 3U);
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("a.avi")));
}

TEST_F(IngestFilmsTest, UselessFilms) {
  source_ = images_.path() / "film.avi";
  photos::WriteFilm(source_, std::vector<cv::Mat>(30, photos::FilmFrame(0)));
  Status status = Run();
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("film.avi: its picture moves by"));
  images_.Write("film.avi", "text");
  status = Run();
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("not a film"));
}

}  // namespace
}  // namespace freegs::stages
