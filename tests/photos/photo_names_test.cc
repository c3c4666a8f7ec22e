// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_names.h"

#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::photos {
namespace {

using testing::ElementsAre;

std::vector<std::string> NamesOf(
    const std::vector<std::pair<std::string, bool>>& files) {
  std::vector<Photo> photos(files.size());
  for (size_t i = 0; i < files.size(); ++i) {
    photos[i].file = files[i].first;
    photos[i].converted = files[i].second;
    photos[i].format = files[i].first.ends_with("png") ? "PNG" : "JPEG";
  }
  AssignNames(&photos);
  std::vector<std::string> names;
  for (const Photo& photo : photos) names.push_back(photo.name);
  return names;
}

TEST(AssignNamesTest, KeepsSafeNamesAndReplacesOthers) {
  EXPECT_THAT(NamesOf({{"a.jpg", false},
                       {"sub/größe_日本.JPG", false},
                       {"it's_\"q\".png", false},
                       {" lead and trail .jpg", false},
                       {"new\nline.jpg", false},
                       {"back\\slash.jpg", false},
                       {"#comment/#x.jpg", false},
                       {"bad\xff\xfeutf8.jpg", false},
                       {"turned.jpg", true},
                       {"scan.tif", true},
                       {"photo.heic", false}}),
              ElementsAre("a.jpg",
                          "sub/größe_日本.JPG",
                          "it's_\"q\".png",
                          "_lead_and_trail_.jpg",
                          "new_line.jpg",
                          "back_slash.jpg",
                          "_comment/_x.jpg",
                          "bad__utf8.jpg",
                          "turned.png",
                          "scan.png",
                          "photo.jpg"));
}

// A workspace may lie on a disk for which these are one name.
TEST(AssignNamesTest, LettersOfAnotherSizeMakeNoOtherName) {
  EXPECT_THAT(
      NamesOf({{"IMG_1.jpg", false},
               {"IMG_1.JPG", false},
               {"a/x.jpg", false},
               {"A/X.jpg", false},
               {"A/y.jpg", false}}),
      ElementsAre(
          "IMG_1.jpg", "IMG_1_2.JPG", "a/x.jpg", "A/X_2.jpg", "A/y.jpg"));
}

TEST(AssignNamesTest, CollisionsGetNumbers) {
  EXPECT_THAT(NamesOf({{"a b.jpg", false},
                       {"a.jpg", true},
                       {"a.png", false},
                       {"a.tif", true},
                       {"a\tb.jpg", false},
                       {"a_b.jpg", false},
                       {"x.tif", true},
                       {"x.png/y.jpg", false}}),
              ElementsAre("a_b_2.jpg",
                          "a_2.png",
                          "a.png",
                          "a_3.png",
                          "a_b_3.jpg",
                          "a_b.jpg",
                          "x_2.png",
                          "x.png/y.jpg"));
}

TEST(AssignNamesTest, FoldersThatAreCalledLikePhotosGetNumbers) {
  EXPECT_THAT(NamesOf({{"a b.png/x.png", false},
                       {"a b.png/y.png", false},
                       {"a\tb.png/x.png", false},
                       {"a_b.png", false},
                       {"a_b_3.png", false}}),
              ElementsAre("a_b_2.png/x.png",
                          "a_b_2.png/y.png",
                          "a_b_4.png/x.png",
                          "a_b.png",
                          "a_b_3.png"));
}

TEST(AssignNamesTest, LongNamesAreCutBetweenCharacters) {
  std::string longest;
  for (int i = 0; i < 80; ++i) longest += "日";
  const std::vector<std::string> names =
      NamesOf({{longest + ".jpg", true}, {longest + "x.jpg", true}});
  for (const std::string& name : names) {
    EXPECT_LE(name.size(), 255U);
    EXPECT_TRUE(name.ends_with(".png"));
  }
  EXPECT_NE(names[0], names[1]);
  EXPECT_TRUE(names[0].starts_with("日日"));
}

}  // namespace
}  // namespace freegs::photos
