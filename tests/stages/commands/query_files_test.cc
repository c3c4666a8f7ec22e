// SPDX-License-Identifier: BSD-3-Clause
// The files of `query --out DIR`.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/image_io.h"
#include "tests/stages/commands/query_fixture.h"

namespace freegs::stages {
namespace {

using testing::HasSubstr;

using QueryFilesTest = QueryFixture;

TEST_F(QueryFilesTest, MasksShowTheHitsInEveryView) {
  AddFeatures();
  const nlohmann::json answer = QueryJson({"--text",
                                           "red apple",
                                           "--min-relevancy",
                                           "0",
                                           "--max-hits",
                                           "2",
                                           "--out",
                                           out()});
  ASSERT_EQ(answer["masks"].size(), workspace_.views.size());
  ASSERT_EQ(answer["hits"].size(), 2u);
  EXPECT_TRUE(
      std::filesystem::exists(std::filesystem::path(out()) / "query.json"));
  size_t overlays = 0;
  for (const View& view : workspace_.views) {
    const std::filesystem::path name(view.name);
    const auto mask = ReadLabels(std::filesystem::path(out()) / "masks" / name);
    ASSERT_TRUE(mask.ok()) << mask.status().message();
    const Image<int32_t> labels = Labels(view);
    ASSERT_EQ(mask->size(), labels.size());
    for (size_t p = 0; p < labels.size(); ++p) {
      const int32_t label = labels.data()[p];
      EXPECT_EQ(mask->data()[p], label == 0 || label == 1 ? 255 : 0);
    }
    overlays += std::filesystem::exists(
        std::filesystem::path(out()) / "overlay" /
        std::filesystem::path(name).replace_extension(".jpg"));
  }
  EXPECT_GT(overlays, 0u);
}

TEST_F(QueryFilesTest, FilesOfAnEarlierAnswerAreRemoved) {
  namespace fs = std::filesystem;
  const auto [x, y] = PixelOf(Labels(workspace_.views[2]), 1);
  const auto ask = [&, x = x, y = y] {
    return Query({"--click",
                  "photo2",
                  std::to_string(x),
                  std::to_string(y),
                  "--out",
                  out()});
  };
  // Somebody has changed the list; what lies elsewhere is not of the answer.
  const fs::path folder = out();
  fs::create_directories(folder / "masks" / "old");
  fs::create_directories(folder / "overlay" / "old");
  for (const char* name : {"masks/old/a.png",
                           "overlay/old/a.jpg",
                           "masks/unlisted.png",
                           "photo.png",
                           "masks/notes.txt"}) {
    WriteText(folder / name, "");
  }
  WriteText(folder / "query.json",
            R"({"masks": [{"mask": "masks/old/a.png"},
                          {"mask": "photo.png"},
                          {"mask": "masks/../photo.png"},
                          {"mask": "masks/notes.txt"},
                          {"mask": 7}, {}, 7]})");
  ASSERT_EQ(ask(), 0) << message_;
  EXPECT_FALSE(fs::exists(folder / "masks/old/a.png"));
  EXPECT_FALSE(fs::exists(folder / "overlay/old/a.jpg"));
  for (const char* name :
       {"masks/unlisted.png", "photo.png", "masks/notes.txt"}) {
    EXPECT_TRUE(fs::exists(folder / name)) << name;
  }
  EXPECT_TRUE(fs::exists(folder / "masks" / "photo1.png"));
  EXPECT_TRUE(fs::exists(folder / "query.json"));

  for (const char* text : {"{", "7", "[]", R"({"masks": 7})", R"({})"}) {
    WriteText(folder / "query.json", text);
    EXPECT_EQ(ask(), 0) << text << ": " << message_;
  }
}

TEST_F(QueryFilesTest, FoldersOfStagesAreNoPlaceForMasks) {
  for (const char* folder : {"undistort", "bootstrap/new", "export"}) {
    EXPECT_EQ(Query({"--click",
                     "photo2",
                     "1",
                     "1",
                     "--out",
                     (workspace_ / folder).string()}),
              2);
    EXPECT_THAT(message_, HasSubstr("the folder of stage"));
  }
  EXPECT_EQ(Query({"--click",
                   "photo2",
                   "1",
                   "1",
                   "--out",
                   (workspace_ / "answer").string()}),
            0)
      << message_;
}

TEST_F(QueryFilesTest, PicturesOfSomebodyElseStay) {
  namespace fs = std::filesystem;
  AddFeatures();
  const fs::path picture = fs::path(out()) / "overlay" / "photo1.jpg";
  fs::create_directories(picture.parent_path());
  WriteText(picture, "mine");
  Query({"--text", "zebra", "--min-relevancy", "1", "--out", out()});
  EXPECT_TRUE(fs::exists(fs::path(out()) / "query.json")) << message_;
  EXPECT_EQ(ReadText(picture), "mine");

  WriteText(workspace_ / "config.ini",
            "[ingest]\nmasks = " + (fs::path(out()) / "masks").string() + "\n");
  EXPECT_EQ(Query({"--click", "photo2", "1", "1", "--out", out()}), 2);
  EXPECT_THAT(message_, HasSubstr("ingest.masks"));
}

}  // namespace
}  // namespace freegs::stages
