// SPDX-License-Identifier: BSD-3-Clause
// Questions about the views of `query --cameras FILE`.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/image_io.h"
#include "tests/stages/camera_json.h"
#include "tests/stages/commands/query_fixture.h"

namespace freegs::stages {
namespace {

using testing::AllOf;
using testing::HasSubstr;

using QueryCamerasTest = QueryFixture;

TEST_F(QueryCamerasTest, CamerasOfAFileWithoutAlignment) {
  nlohmann::json rows = PoseJson(workspace_.views[4].cam_from_world);
  rows.push_back({0, 0, 0, 1});  // A fourth row is allowed.
  const Pinhole& camera = workspace_.views[4].camera;
  nlohmann::json file;
  file["intrinsics"] = IntrinsicsJson(camera);
  file["train"] = nlohmann::json::object();
  file["test"]["new.png"] = rows;
  const std::string path = (out_ / "cameras.json").string();
  WriteText(path, file.dump());
  const auto [x, y] = PixelOf(Labels(workspace_.views[4]), 1);
  const nlohmann::json answer = QueryJson({"--click",
                                           "new",
                                           std::to_string(x),
                                           std::to_string(y),
                                           "--cameras",
                                           path,
                                           "--no-align",
                                           "--out",
                                           out()});
  EXPECT_EQ(answer["hits"][0]["id"], 2);
  ASSERT_EQ(answer["masks"].size(), 1u);
  EXPECT_GT(answer["masks"][0]["pixels"], 0);
  EXPECT_TRUE(std::filesystem::exists(out() + "/overlay/new.jpg"));

  // A size limits the masks, but pixels are still those of the camera.
  const nlohmann::json small = QueryJson({"--click",
                                          "new",
                                          std::to_string(x),
                                          std::to_string(y),
                                          "--cameras",
                                          path,
                                          "--no-align",
                                          "--size",
                                          "16",
                                          "--out",
                                          out()});
  EXPECT_EQ(small["hits"][0]["id"], 2);
  EXPECT_EQ(small["query"], answer["query"]);
  const auto mask = ReadLabels(std::filesystem::path(out()) / "masks/new.png");
  ASSERT_TRUE(mask.ok()) << mask.status().message();
  EXPECT_EQ(mask->width(), 16);

  // A picture that is too large as a whole still has pixels to click.
  const Pinhole huge = camera.Resized(64000, 48000);
  file["intrinsics"] = IntrinsicsJson(huge);
  WriteText(path, file.dump());
  const std::vector<std::string> masks = {
      "--cameras", path, "--no-align", "--size", "16"};
  std::vector<std::string> question = {"--click",
                                       "new",
                                       std::to_string(1000 * x + 500),
                                       std::to_string(1000 * y + 500)};
  question.insert(question.end(), masks.begin(), masks.end());
  EXPECT_EQ(QueryJson(question)["query"]["view"], "new.png");
  question = {"--box", "new", "0", "0", "64000", "48000"};
  question.insert(question.end(), masks.begin(), masks.end());
  EXPECT_EQ(Query(question), 3);
  EXPECT_THAT(message_,
              AllOf(HasSubstr("query: view new.png is 64000 x 48000 pixels"),
                    HasSubstr("too large for --box")));
}

TEST_F(QueryCamerasTest, AViewOfTheFileComesBeforeAPhotoOfThatName) {
  // The file's photo1.png is where photo4.png is, and twice as large.
  const nlohmann::json rows = PoseJson(workspace_.views[4].cam_from_world);
  const Pinhole& photo = workspace_.views[4].camera;
  View large = workspace_.views[4];
  large.camera = photo.Resized(2 * photo.width, 2 * photo.height);
  nlohmann::json file;
  file["intrinsics"] = IntrinsicsJson(large.camera);
  file["test"]["photo1.png"] = rows;
  const std::string path = (out_ / "cameras.json").string();
  WriteText(path, file.dump());
  // Outside of the photos of the workspace.
  const Image<int32_t> labels = Labels(large);
  std::pair<int, int> pixel = {0, 0};
  for (int y = photo.height; y + 1 < labels.height(); ++y) {
    for (int x = 1; x + 1 < labels.width(); ++x) {
      if (labels(x, y) == 1 && labels(x - 1, y) == 1 && labels(x + 1, y) == 1 &&
          labels(x, y - 1) == 1 && labels(x, y + 1) == 1) {
        pixel = {x, y};
      }
    }
  }
  ASSERT_NE(pixel.second, 0);
  for (const char* name : {"photo1", "photo1.png"}) {
    const nlohmann::json answer = QueryJson({"--click",
                                             name,
                                             std::to_string(pixel.first),
                                             std::to_string(pixel.second),
                                             "--cameras",
                                             path,
                                             "--no-align"});
    EXPECT_EQ(answer["hits"][0]["id"], 2);
  }
  // A photo that the file does not name.
  const auto [x, y] = PixelOf(Labels(workspace_.views[5]), 0);
  const nlohmann::json of_photo = QueryJson({"--click",
                                             "photo5",
                                             std::to_string(x),
                                             std::to_string(y),
                                             "--cameras",
                                             path,
                                             "--no-align"});
  EXPECT_EQ(of_photo["hits"][0]["id"], 1);
  // A name that nobody has: those of both are listed.
  const std::vector<std::string> others = {
      "1", "1", "--cameras", path, "--no-align"};
  const auto ask = [&](const std::string& name) {
    std::vector<std::string> question = {"--click", name};
    question.insert(question.end(), others.begin(), others.end());
    return Query(question);
  };
  file["test"]["shelf.png"] = rows;
  WriteText(path, file.dump());
  EXPECT_EQ(ask("s"), 2);
  EXPECT_THAT(message_, AllOf(HasSubstr("shelf.png"), HasSubstr("photo5.png")));
  // Two views of the file have this name, so it is not that of the photo.
  file["test"]["photo5.png"] = rows;
  file["test"]["photo5.jpg"] = rows;
  WriteText(path, file.dump());
  EXPECT_EQ(ask("photo5"), 2);
  EXPECT_THAT(message_, HasSubstr("several have this name"));
  // A name may not be in both sections, also where no picture is written.
  file["train"]["photo5.jpg"] = rows;
  WriteText(path, file.dump());
  EXPECT_EQ(ask("photo5.jpg"), 3);
  EXPECT_THAT(message_,
              AllOf(HasSubstr("cameras.json: view \"photo5.jpg\""),
                    HasSubstr("a name of its own")));
}

}  // namespace
}  // namespace freegs::stages
