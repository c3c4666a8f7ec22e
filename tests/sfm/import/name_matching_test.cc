// SPDX-License-Identifier: BSD-3-Clause
// Names to photos.

#include "sfm/import/name_matching.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::sfm {
namespace {

using testing::ElementsAre;

std::vector<SfmPhoto> Photos(const std::vector<std::string>& names) {
  std::vector<SfmPhoto> photos;
  for (const std::string& name : names) {
    SfmPhoto photo;
    photo.name = name;
    photos.push_back(photo);
  }
  return photos;
}

std::vector<int> Match(const std::vector<std::string>& names,
                       const std::vector<SfmPhoto>& photos) {
  return MatchNames(names, photos).photos;
}

TEST(MatchNames, FoldersAndExtensionsMayDiffer) {
  const auto photos = Photos({"0001.jpg", "0002.jpg", "sub/0003.png"});
  EXPECT_THAT(
      Match({"images/0002.jpg", "./0001", "a/b/sub/0003.jpg", "0004.jpg"},
            photos),
      ElementsAre(1, 0, 2, -1));
}

TEST(MatchNames, TheUsersFileNameCountsToo) {
  auto photos = Photos({"photo_1.jpg", "photo_2.jpg"});
  photos[1].file = "my folder/IMG (2).tiff";
  EXPECT_THAT(Match({"IMG (2).tiff", "photo_1"}, photos), ElementsAre(1, 0));
}

TEST(MatchNames, MoreFoldersWin) {
  const auto photos = Photos({"train/r_0.png", "test/r_0.png"});
  EXPECT_THAT(Match({"./test/r_0", "./train/r_0", "val/r_0"}, photos),
              ElementsAre(1, 0, -1));
  EXPECT_THAT(Match({"r_0"}, photos), ElementsAre(-1));
}

TEST(MatchNames, AllFoldersOfThePhotoWin) {
  const auto photos = Photos({"0001.jpg", "sub/0001.jpg"});
  EXPECT_THAT(Match({"images/0001.jpg", "images/sub/0001.jpg"}, photos),
              ElementsAre(0, 1));
  EXPECT_THAT(Match({"images/sub/0001.jpg", "images/0001"}, photos),
              ElementsAre(1, 0));
  // The extension counts for more.
  const auto mixed = Photos({"0001.jpg", "sub/0001.png"});
  EXPECT_THAT(Match({"images/0001.png"}, mixed), ElementsAre(1));
  // Neither photo has all its folders in the name.
  EXPECT_THAT(Match({"images/r.jpg"}, Photos({"a/r.jpg", "b/r.jpg"})),
              ElementsAre(-1));
}

TEST(MatchNames, APhotoIsGivenOnce) {
  // Only the training photos are there: test/r_0 must not take one of them.
  const auto photos = Photos({"train/r_0.png", "train/r_1.png"});
  EXPECT_THAT(Match({"test/r_0", "train/r_0", "train/r_1"}, photos),
              ElementsAre(-1, 0, 1));
}

TEST(MatchNames, TiesAreTold) {
  const auto photos = Photos({"sub/a.png", "0.png"});
  const std::vector<std::string> names = {
      "left/0.png", "right/0.png", "third/0.png", "images/sub/a.png"};
  const NameMatches first = MatchNames(names, photos);
  EXPECT_THAT(first.photos, ElementsAre(1, -1, -1, 0));
  ASSERT_EQ(first.ties.size(), 1u);
  EXPECT_EQ(first.ties[0].photo, 1);
  EXPECT_EQ(first.ties[0].taken, 0);
  EXPECT_EQ(first.ties[0].other, 1);
  // The folder of the photos says which one is meant.
  const NameMatches right = MatchNames(names, photos, "right");
  EXPECT_THAT(right.photos, ElementsAre(-1, 1, -1, 0));
  EXPECT_TRUE(right.ties.empty());
  EXPECT_EQ(MatchNames(names, photos, "elsewhere").ties.size(), 1u);
  // A better name ends a tie.
  EXPECT_TRUE(MatchNames({"left/0", "right/0", "0.png"}, photos).ties.empty());
}

TEST(MatchNames, FoldersThatBothSidesKnowContradict) {
  // right/2.jpg could not be used.
  const auto photos = Photos({"left/1.jpg", "left/2.jpg", "right/1.jpg"});
  EXPECT_THAT(Match({"right/1.jpg", "right/2.jpg"}, photos),
              ElementsAre(2, -1));
  EXPECT_THAT(Match({"left/3.jpg", "other/2.jpg"}, photos),
              ElementsAre(-1, -1));
  // Folders that only one side has say nothing.
  EXPECT_THAT(Match({"images_2/2.jpg"}, photos), ElementsAre(1));
}

TEST(MatchNames, DotsAndExtensionsThatTellApart) {
  const auto photos = Photos({"view.1.png", "view.2.png", "a.jpg", "a.png"});
  EXPECT_THAT(Match({"view.2", "view.1.png", "a.png", "a"}, photos),
              ElementsAre(1, 0, 3, -1));
}

TEST(MatchNames, OddInput) {
  EXPECT_THAT(Match({"", "/", ".", "..", ".jpg"}, Photos({"a.jpg", ""})),
              ElementsAre(-1, -1, -1, -1, -1));
  EXPECT_THAT(Match({}, {}), ElementsAre());
  EXPECT_THAT(Match({"C:\\data\\a.jpg"}, Photos({"a.jpg"})), ElementsAre(0));
}

}  // namespace
}  // namespace freegs::sfm
