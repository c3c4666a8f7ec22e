// SPDX-License-Identifier: BSD-3-Clause
// Films and their frames, of `render --path`.

#include <cmath>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/videoio.hpp>

#include "tests/stages/commands/render_fixture.h"

namespace freegs::stages {
namespace {

using testing::HasSubstr;

class RenderFilmTest : public RenderFixture {
 protected:
  // Four pictures for each second of an orbit. Forgets what was printed before.
  Status RenderFrames(const char* seconds, const char* what) {
    output_.str("");
    return Render({workspace(),
                   "--path",
                   "orbit",
                   "--out",
                   out(),
                   "--what",
                   what,
                   "--seconds",
                   seconds,
                   "--fps",
                   "4"});
  }
};

TEST_F(RenderFilmTest, FilmOfAnOrbit) {
  workspace_.AddInstances();
  const std::string film = (out_.path() / "sub" / "film.mp4").string();
  for (const char* what : {"color", "depth", "instances", "both"}) {
    const Status status = Render({workspace(),
                                  "--path",
                                  "orbit",
                                  "--video",
                                  film,
                                  "--what",
                                  what,
                                  "--seconds",
                                  "0.5",
                                  "--fps",
                                  "20"});
    ASSERT_TRUE(status.ok()) << status.message();
    cv::VideoCapture capture(film);
    ASSERT_TRUE(capture.isOpened());
    const bool both = std::string(what) == "both";
    EXPECT_EQ(capture.get(cv::CAP_PROP_FRAME_WIDTH), both ? 64 : 32);
    EXPECT_EQ(capture.get(cv::CAP_PROP_FRAME_HEIGHT), 24);
    EXPECT_EQ(capture.get(cv::CAP_PROP_FRAME_COUNT), 10);
    EXPECT_EQ(capture.get(cv::CAP_PROP_FPS), 20);
  }
  EXPECT_THAT(output_.str(), HasSubstr("10 pictures of 64 x 24 in"));
}

TEST_F(RenderFilmTest, FilmThroughThePhotosAndThroughAFile) {
  const std::string cameras = (out_.path() / "cameras.json").string();
  WriteText(cameras, MovedCameras("").dump());
  for (const std::string& path : {std::string("photos"), cameras}) {
    const Status status = Render({workspace(),
                                  "--path",
                                  path,
                                  "--video",
                                  (out_.path() / "f.mp4").string(),
                                  "--seconds",
                                  "1",
                                  "--fps",
                                  "5"});
    ASSERT_TRUE(status.ok()) << status.message();
  }
  // The file has a single view that is no photo.
  ASSERT_TRUE(Render({workspace(),
                      "--path",
                      cameras,
                      "--out",
                      out(),
                      "--seconds",
                      "1",
                      "--fps",
                      "3"})
                  .ok());
  EXPECT_THAT(output_.str(), HasSubstr("3 pictures"));
  const auto frame = ReadRgb(out_.path() / "sub" / "frame_0002.png");
  ASSERT_TRUE(frame.ok());
  const ImageU8 expected =
      ToU8(splat::RenderView(workspace_.model,
                             workspace_.views[3].camera,
                             workspace_.views[3].cam_from_world,
                             WhiteBackground(),
                             pool_)
               .color);
  EXPECT_EQ(frame->width(), expected.width());
  double difference = 0;
  for (size_t k = 0; k < expected.size(); ++k) {
    difference += std::abs(frame->data()[k] - expected.data()[k]);
  }
  EXPECT_LT(difference / static_cast<double>(expected.size()), 1);
}

TEST_F(RenderFilmTest, FramesOfALongerWayAreRemoved) {
  const auto exists = [&](const char* name) {
    return std::filesystem::exists(std::filesystem::path(out()) / name);
  };
  ASSERT_TRUE(RenderFrames("1", "depth").ok());
  EXPECT_TRUE(exists("frame_0004.png"));
  EXPECT_TRUE(exists("preview/frame_0004.png"));
  ASSERT_TRUE(RenderFrames("0.5", "depth").ok());
  EXPECT_THAT(output_.str(), HasSubstr("2 pictures of a longer path"));
  for (const char* name : {"frame_0001.png", "frame_0002.png"}) {
    EXPECT_TRUE(exists(name)) << name;
    EXPECT_TRUE(exists((std::string("preview/") + name).c_str())) << name;
  }
  for (const char* name : {"frame_0003.png", "frame_0004.png"}) {
    EXPECT_FALSE(exists(name)) << name;
    EXPECT_FALSE(exists((std::string("preview/") + name).c_str())) << name;
  }
}

TEST_F(RenderFilmTest, PicturesThatReplacedFramesStay) {
  ASSERT_TRUE(RenderFrames("1", "color").ok());
  nlohmann::json cameras = Cameras("", Sim3d());
  cameras["test"] = nlohmann::json::object();
  cameras["train"]["frame_0003.jpg"] = cameras["train"]["photo1.png"];
  WriteText(out_.path() / "cameras.json", cameras.dump());
  const Status status = Render({workspace(),
                                "--cameras",
                                (out_.path() / "cameras.json").string(),
                                "--no-align",
                                "--out",
                                out()});
  ASSERT_TRUE(status.ok()) << status.message();
  ASSERT_TRUE(RenderFrames("0.25", "color").ok());
  EXPECT_THAT(output_.str(), HasSubstr("1 pictures of a longer path"));
  const std::filesystem::path folder = out();
  EXPECT_FALSE(std::filesystem::exists(folder / "frame_0002.png"));
  EXPECT_TRUE(std::filesystem::exists(folder / "frame_0003.png"));
}

TEST_F(RenderFilmTest, FramesOfSomebodyElseStay) {
  const std::filesystem::path folder = out();
  for (const char* name : {"frame_0003.png", "frame_0004.png"}) {
    WriteText(folder / name, "mine");
    WriteText(folder / "preview" / name, "mine");
  }
  ASSERT_TRUE(RenderFrames("0.5", "color").ok());
  EXPECT_THAT(output_.str(), HasSubstr("frame_0003.png and later frames stay"));
  EXPECT_EQ(ReadText(folder / "frame_0003.png"), "mine");
  EXPECT_EQ(ReadText(folder / "frame_0004.png"), "mine");

  // The list covers three frames, and no previews.
  ASSERT_TRUE(RenderFrames("0.75", "color").ok());
  ASSERT_TRUE(RenderFrames("0.25", "color").ok());
  EXPECT_THAT(output_.str(), HasSubstr("2 pictures of a longer path"));
  EXPECT_THAT(output_.str(), HasSubstr("frame_0004.png and later frames stay"));
  EXPECT_TRUE(std::filesystem::exists(folder / "frame_0001.png"));
  EXPECT_FALSE(std::filesystem::exists(folder / "frame_0003.png"));
  EXPECT_EQ(ReadText(folder / "frame_0004.png"), "mine");
  EXPECT_EQ(ReadText(folder / "preview" / "frame_0003.png"), "mine");

  // A list that is damaged covers nothing.
  WriteText(folder / "rendered_frames.json", R"({"frames": -1})");
  ASSERT_TRUE(RenderFrames("0.25", "color").ok());
  EXPECT_EQ(ReadText(folder / "frame_0004.png"), "mine");
}

TEST_F(RenderFilmTest, WordsOfFilmsThatDoNotFit) {
  const std::vector<std::vector<std::string>> wrong = {
      {"--video", "a.mp4"},
      {"--out", "a", "--seconds", "3"},
      {"--video", "a.gif", "--path", "orbit"},
      {"--video", "a.mp4", "--path", "orbit", "--cameras", "c.json"},
      {"--out", "a", "--what", "both"},
      {"--out", "a", "--path", "orbit", "--what", "both"},
      {"--video", "a.mp4", "--path", "orbit", "--no-align"},
      {"--video", "a.mp4", "--path", "orbit", "--seconds", "0"}};
  for (std::vector<std::string> words : wrong) {
    words.insert(words.begin(), workspace());
    EXPECT_EQ(Render(words).code(), StatusCode::kInvalidArgument)
        << testing::PrintToString(words);
  }
  EXPECT_EQ(
      Render({workspace(), "--video", out() + ".mp4", "--path", "none.json"})
          .code(),
      StatusCode::kBadInput);
}

}  // namespace
}  // namespace freegs::stages
