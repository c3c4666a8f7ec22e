// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_selection.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::photos {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<Photo> MakePhotos(int count) {
  std::vector<Photo> photos(count);
  for (int i = 0; i < count; ++i) {
    photos[i].file = "p" + std::to_string(i) + ".jpg";
    photos[i].format = "JPEG";
    photos[i].width = 40;
    photos[i].height = 30;
    photos[i].hash = std::to_string(i);
    photos[i].sharpness = (i * 7) % 10;
  }
  return photos;
}

std::vector<int> With(PhotoSplit split, const std::vector<Photo>& photos) {
  std::vector<int> indices;
  for (size_t i = 0; i < photos.size(); ++i) {
    if (photos[i].split == split) indices.push_back(static_cast<int>(i));
  }
  return indices;
}

TEST(RejectDuplicatesTest, TheFirstUsableOneStays) {
  std::vector<Photo> photos = MakePhotos(5);
  photos[0].split = PhotoSplit::kRejected;
  photos[0].hash = "same";
  photos[1].hash = photos[3].hash = photos[4].hash = "same";
  RejectDuplicates(&photos);
  EXPECT_THAT(With(PhotoSplit::kRejected, photos), ElementsAre(0, 3, 4));
  EXPECT_THAT(photos[3].reason, HasSubstr("duplicate of p1.jpg"));
}

TEST(RejectDuplicatesTest, TheShorterNameStays) {
  std::vector<Photo> photos = MakePhotos(4);
  photos[0].file = "a copy of p2.jpg";
  photos[0].hash = photos[2].hash = photos[3].hash = "same";
  RejectDuplicates(&photos);
  EXPECT_THAT(With(PhotoSplit::kRejected, photos), ElementsAre(0, 3));
  EXPECT_THAT(photos[0].reason, HasSubstr("duplicate of p2.jpg"));
}

TEST(RejectBlurredTest, TheSharpestOfEachWindowStays) {
  std::vector<Photo> photos = MakePhotos(20);
  RejectBlurred(0.25, &photos);
  // Windows of four; sharpness 0 7 4 1 | 8 5 2 9 | 6 3 0 7 | 4 1 8 5 | 2 9 6 3.
  EXPECT_THAT(With(PhotoSplit::kTrain, photos), ElementsAre(1, 7, 11, 14, 17));
  EXPECT_EQ(photos[0].reason, "blurrier than its neighbours");
}

TEST(RejectBlurredTest, TheBlurriestOfEachWindowGoes) {
  std::vector<Photo> photos = MakePhotos(20);
  RejectBlurred(0.75, &photos);
  EXPECT_THAT(With(PhotoSplit::kRejected, photos),
              ElementsAre(0, 6, 10, 13, 16));
}

TEST(RejectBlurredTest, KeepsTheFractionWithoutLongGaps) {
  for (const int count : {3, 4, 7, 50, 101}) {
    for (const double fraction : {0.01, 0.1, 0.3, 0.5, 0.51, 0.9, 0.99, 1.0}) {
      std::vector<Photo> photos = MakePhotos(count);
      RejectBlurred(fraction, &photos);
      const std::vector<int> kept = With(PhotoSplit::kTrain, photos);
      const int expected =
          std::max(3, static_cast<int>(std::lround(fraction * count)));
      EXPECT_EQ(kept.size(), std::min<size_t>(expected, count));
      const int window = (count + expected - 1) / expected;
      for (size_t i = 1; i < kept.size(); ++i) {
        EXPECT_LE(kept[i] - kept[i - 1], 2 * std::max(window, 2));
      }
    }
  }
}

TEST(RejectBlurredTest, EqualSharpnessKeepsTheFirst) {
  std::vector<Photo> photos = MakePhotos(8);
  for (Photo& photo : photos) photo.sharpness = 1;
  RejectBlurred(0.5, &photos);
  EXPECT_THAT(With(PhotoSplit::kTrain, photos), ElementsAre(0, 2, 4, 6));
}

TEST(AssignHoldoutTest, EveryEighthOfTheUsable) {
  std::vector<Photo> photos = MakePhotos(20);
  photos[3].split = PhotoSplit::kRejected;
  const auto unmatched = AssignHoldout({}, &photos);
  ASSERT_TRUE(unmatched.ok());
  EXPECT_THAT(*unmatched, IsEmpty());
  EXPECT_THAT(With(PhotoSplit::kHoldout, photos), ElementsAre(0, 9, 17));
  EXPECT_THAT(With(PhotoSplit::kRejected, photos), ElementsAre(3));
}

TEST(AssignHoldoutTest, TheRuleMayTakeNoPhoto) {
  for (const HoldoutRule& rule :
       {HoldoutRule{.every = 0}, HoldoutRule{.pattern = "none"}}) {
    std::vector<Photo> photos = MakePhotos(20);
    ASSERT_TRUE(AssignHoldout(rule, &photos).ok());
    EXPECT_THAT(With(PhotoSplit::kHoldout, photos), IsEmpty());
  }
}

TEST(AssignHoldoutTest, PatternMatchesWholeOrBaseName) {
  std::vector<Photo> photos = MakePhotos(6);
  photos[1].file = "val/a.jpg";
  photos[2].file = "train/test_b.jpg";
  photos[3].file = "test_c.jpg";
  std::vector<Photo> again = photos;
  ASSERT_TRUE(AssignHoldout({.pattern = "test_*"}, &photos).ok());
  EXPECT_THAT(With(PhotoSplit::kHoldout, photos), ElementsAre(2, 3));
  ASSERT_TRUE(AssignHoldout({.pattern = "val/*"}, &again).ok());
  EXPECT_THAT(With(PhotoSplit::kHoldout, again), ElementsAre(1));
  const auto unmatched = AssignHoldout({.pattern = "nothing*"}, &again);
  ASSERT_TRUE(unmatched.ok());
  EXPECT_THAT(*unmatched, ElementsAre("nothing*"));
  EXPECT_THAT(With(PhotoSplit::kHoldout, again), IsEmpty());
}

TEST(AssignHoldoutTest, ListOfNames) {
  std::vector<Photo> photos = MakePhotos(6);
  photos[1].file = "val/a.jpg";
  photos[2].file = "val/b.jpg";
  const auto names =
      ParseNameList("# held out\n\np0.jpg\r\nval/b.jpg\nmissing.jpg\n");
  EXPECT_THAT(names, ElementsAre("p0.jpg", "val/b.jpg", "missing.jpg"));
  EXPECT_THAT(ParseNameList("\xef\xbb\xbfp0.jpg\n"), ElementsAre("p0.jpg"));
  const auto unmatched = AssignHoldout({.names = names}, &photos);
  ASSERT_TRUE(unmatched.ok());
  EXPECT_THAT(*unmatched, ElementsAre("missing.jpg"));
  EXPECT_THAT(With(PhotoSplit::kHoldout, photos), ElementsAre(0, 2));
}

TEST(AssignHoldoutTest, NamesMayBeWrittenInOtherWays) {
  const auto held = [](const std::string& list) {
    std::vector<Photo> photos = MakePhotos(7);
    photos[1].file = "val/test_01.tif";
    photos[1].name = "val/test_01.png";
    photos[2].file = "val/twice.jpg";
    photos[3].file = "train/twice.jpg";
    photos[4].file = "twice.png";
    photos[5].file = " spaced .jpg";
    const auto unmatched =
        AssignHoldout({.names = ParseNameList(list)}, &photos);
    return unmatched.ok() ? With(PhotoSplit::kHoldout, photos)
                          : std::vector<int>{-1};
  };
  EXPECT_THAT(held("p0"), ElementsAre(0));
  EXPECT_THAT(held("./p0.jpg\n"), ElementsAre(0));
  EXPECT_THAT(held("  p0.jpg \t\r\n"), ElementsAre(0));
  EXPECT_THAT(held("test_01"), ElementsAre(1));
  EXPECT_THAT(held("val/test_01"), ElementsAre(1));
  EXPECT_THAT(held("test_01.png"), ElementsAre(1));  // As in the workspace.
  EXPECT_THAT(held("./val/test_01.png"), ElementsAre(1));
  EXPECT_THAT(held("twice.jpg"), ElementsAre(2, 3));
  EXPECT_THAT(held("val/twice"), ElementsAre(2));
  EXPECT_THAT(held("twice.png"), ElementsAre(4));
  EXPECT_THAT(held("twice\np0"), ElementsAre(0));  // Which of three?
  EXPECT_THAT(held(" spaced .jpg"), ElementsAre(5));
  EXPECT_THAT(held("  # p6.jpg\np0.jpg"), ElementsAre(0));
}

TEST(AssignHoldoutTest, AWholeNameIsOnlyThatPhoto) {
  std::vector<Photo> photos = MakePhotos(5);
  photos[1].file = "more/" + photos[0].file;
  const std::vector<std::string> names = {photos[0].file};
  ASSERT_TRUE(AssignHoldout({.names = names}, &photos).ok());
  EXPECT_THAT(With(PhotoSplit::kHoldout, photos), ElementsAre(0));
}

TEST(AssignHoldoutTest, AListThatFitsNoPhotoIsAnError) {
  std::vector<Photo> photos = MakePhotos(6);
  const std::vector<std::string> names = {"a.jpg", "b.jpg", "c", "d", "e"};
  const Status status = AssignHoldout({.names = names}, &photos).status();
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("a.jpg, b.jpg, c and 2 more"));
  // A photo that cannot be used is a photo all the same.
  photos[1].split = PhotoSplit::kRejected;
  const auto unmatched = AssignHoldout({.names = {"p1.jpg"}}, &photos);
  ASSERT_TRUE(unmatched.ok()) << unmatched.status().message();
  EXPECT_THAT(*unmatched, ElementsAre("p1.jpg"));
  EXPECT_THAT(With(PhotoSplit::kHoldout, photos), IsEmpty());
}

TEST(AssignHoldoutTest, TwoMustBeLeftForTraining) {
  std::vector<Photo> photos = MakePhotos(3);
  EXPECT_TRUE(AssignHoldout({}, &photos).ok());
  for (const HoldoutRule& rule : {HoldoutRule{.every = 1},
                                  HoldoutRule{.every = 2},
                                  HoldoutRule{.pattern = "*"}}) {
    const auto result = AssignHoldout(rule, &photos);
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.status().code(), StatusCode::kBadInput);
  }
  EXPECT_FALSE(HoldoutRule{.every = -1}.Check().ok());
}

TEST(AssignCameraGroupsTest, GroupsBySizeCameraAndFocalLength) {
  std::vector<Photo> photos = MakePhotos(8);
  photos[7].digital_zoom = 3;
  photos[1].width = 41;
  photos[3].model = "M";
  photos[4].focal_length_mm = 4.2;
  photos[5].split = PhotoSplit::kRejected;
  AssignCameraGroups(&photos);
  std::vector<int> groups;
  for (const Photo& photo : photos) groups.push_back(photo.camera_group);
  EXPECT_THAT(groups, ElementsAre(0, 1, 0, 2, 3, -1, 0, 4));
}

// Two films, and the two cameras of a rig, may have different lenses.
TEST(AssignCameraGroupsTest, FilmsAndFoldersWithoutExifAreToldApart) {
  std::vector<Photo> photos = MakePhotos(44);
  for (int i = 0; i < 40; ++i) {
    Photo& photo = photos[i];
    if (i < 20) {
      photo.film = i < 10 ? "wide.mp4" : "tele.mp4";
    } else {
      photo.file = (i < 30 ? "left/" : "right/") + photo.file;
    }
  }
  for (int i = 40; i < 44; ++i) photos[i].file = "few/" + photos[i].file;
  AssignCameraGroups(&photos);
  std::vector<int> tens;
  for (int i = 0; i < 44; ++i) {
    EXPECT_EQ(photos[i].camera_group, photos[i - i % 10].camera_group) << i;
    if (i % 10 == 0) tens.push_back(photos[i].camera_group);
  }
  EXPECT_THAT(tens, ElementsAre(0, 1, 2, 3, 4));

  // EXIF knows better, and few photos do not tell a lens.
  for (int i = 20; i < 40; ++i) photos[i].model = "M";
  for (int i = 30; i < 32; ++i) photos[i].split = PhotoSplit::kRejected;
  for (int i = 10; i < 12; ++i) photos[i].split = PhotoSplit::kRejected;
  AssignCameraGroups(&photos);
  EXPECT_EQ(photos[0].camera_group, 0);
  EXPECT_EQ(photos[19].camera_group, 1);
  EXPECT_EQ(photos[20].camera_group, photos[39].camera_group);
  EXPECT_NE(photos[20].camera_group, photos[43].camera_group);
}

}  // namespace
}  // namespace freegs::photos
