// SPDX-License-Identifier: BSD-3-Clause

#include "stages/disturb/disturb_photos.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "photos/photo_decode.h"
#include "photos/photo_header.h"
#include "photos/photo_scan.h"
#include "stages/disturb/exif_block.h"
#include "tests/photos/photo_test_files.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using photos::MakeExif;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsSubsetOf;
using ::testing::SizeIs;

class DisturbPhotosTest : public ::testing::Test {
 protected:
  void SetUp() override {
    for (int i = 1; i <= 10; ++i) {
      const std::string name = "p" + std::to_string(i) + ".jpg";
      names_.push_back(name);
      folder_.Write("images/" + name,
                    photos::WithExif(photos::MakeJpeg(64, 48, i), exif_));
    }
    folder_.Write("images/masks/p3.png", photos::MakePng(64, 48, 99));
  }

  // The photographs of the new folder, in natural order.
  std::vector<std::string> Disturb(const std::string& text, uint64_t seed = 1) {
    out_ = folder_ / ("out" + std::to_string(++outs_));
    const Status status =
        DisturbPhotos(*ParseDisturbance(text), folder_ / "images", out_, seed);
    EXPECT_TRUE(status.ok()) << status.message();
    const auto scan = photos::ScanPhotos(out_, {out_ / "masks"});
    return scan.ok() ? scan->files : std::vector<std::string>();
  }

  std::string Before(const std::string& name) const {
    return ReadText(folder_ / "images" / name);
  }
  std::string After(const std::string& name) const {
    return ReadText(out_ / name);
  }

  const std::string exif_ = MakeExif({.orientation = 6, .focal_35mm = 35});
  const TemporaryFolder folder_;
  std::vector<std::string> names_;
  fs::path out_;
  int outs_ = 0;
};

TEST_F(DisturbPhotosTest, PixelsChangeAndNamesExifAndMasksStay) {
  for (const char* text : {"noise:5", "blur:1", "jpeg:30", "mover:0.2"}) {
    EXPECT_EQ(Disturb(text), names_) << text;
    EXPECT_NE(After("p1.jpg"), Before("p1.jpg"));
    EXPECT_EQ(ExifBlockOf(After("p1.jpg")), exif_);
    const auto header = photos::ParsePhotoHeader(After("p1.jpg"));
    ASSERT_TRUE(header.ok()) << header.status().message();
    EXPECT_EQ(header->width, 64);
    EXPECT_EQ(After("masks/p3.jpg.png"), Before("masks/p3.png"));
  }
  EXPECT_LT(After("p1.jpg").size(), 20000u);
}

TEST_F(DisturbPhotosTest, TheSameSeedGivesTheSameFiles) {
  Disturb("noise:5", 3);
  const std::string first = After("p4.jpg");
  Disturb("noise:5", 3);
  EXPECT_EQ(After("p4.jpg"), first);
  Disturb("noise:5", 4);
  EXPECT_NE(After("p4.jpg"), first);
}

TEST_F(DisturbPhotosTest, DroppedPhotographsAreMissing) {
  EXPECT_THAT(Disturb("drop:0"), SizeIs(10));
  const std::vector<std::string> seven = Disturb("drop:0.3");
  EXPECT_THAT(seven, SizeIs(7));
  EXPECT_THAT(seven, IsSubsetOf(names_));
  EXPECT_EQ(After(seven[0]), Before(seven[0]));
  EXPECT_NE(Disturb("drop:0.3", 2), seven);
}

TEST_F(DisturbPhotosTest, ViewsAreNeighbours) {
  const std::vector<std::string> three = Disturb("views:3");
  ASSERT_THAT(three, SizeIs(3));
  const auto at =
      std::search(names_.begin(), names_.end(), three.begin(), three.end());
  EXPECT_NE(at, names_.end());
  EXPECT_THAT(Disturb("views:9"), SizeIs(9));
}

TEST_F(DisturbPhotosTest, ShuffledPhotographsKeepNamesAndMasks) {
  const std::vector<std::string> files = Disturb("shuffle");
  ASSERT_THAT(files, SizeIs(10));
  std::vector<std::string> names;
  for (const std::string& file : files) {
    names.push_back(fs::path(file).filename().string());
    EXPECT_EQ(After(file), Before(names.back()));
    if (names.back() == "p3.jpg") {
      EXPECT_TRUE(fs::exists(out_ / "masks" / (file + ".png")));
    }
  }
  EXPECT_NE(names, names_);
  EXPECT_EQ(files[0], "0001/" + names[0]);
  std::sort(names.begin(), names.end());
  std::sort(names_.begin(), names_.end());
  EXPECT_EQ(names, names_);
}

TEST_F(DisturbPhotosTest, FocalLengthsAreTimesWhatTheyWere) {
  Disturb("focal:2");
  const std::string after = After("p1.jpg");
  const auto before = photos::ParsePhotoHeader(Before("p1.jpg"));
  const auto header = photos::ParsePhotoHeader(after);
  ASSERT_TRUE(before.ok() && header.ok());
  EXPECT_NEAR(photos::FocalLengthPixels(header->exif, 64, 48).value_or(0),
              2 * photos::FocalLengthPixels(before->exif, 64, 48).value_or(9),
              1e-3);
  EXPECT_EQ(header->exif.orientation, 6);
  // Only EXIF is new.
  EXPECT_EQ(*WithExifBlock(after, ""), *WithExifBlock(Before("p1.jpg"), ""));
}

TEST_F(DisturbPhotosTest, WithoutExifTheLongestSideCounts) {
  folder_.Write("images/p1.jpg", photos::MakeJpeg(64, 48, 1));
  Disturb("focal:1.5");
  const auto header = photos::ParsePhotoHeader(After("p1.jpg"));
  ASSERT_TRUE(header.ok());
  EXPECT_NEAR(photos::FocalLengthPixels(header->exif, 64, 48).value_or(0),
              1.5 * 64,
              1e-3);
}

TEST_F(DisturbPhotosTest, PngsStayPngsUnlessCompressed) {
  folder_.Write("images/q.png", photos::MakePng(64, 48, 5));
  Disturb("noise:5");
  EXPECT_EQ(photos::ParsePhotoHeader(After("q.png"))->format,
            photos::PhotoFormat::kPng);
  Disturb("jpeg:30");
  EXPECT_EQ(photos::ParsePhotoHeader(After("q.png"))->format,
            photos::PhotoFormat::kJpeg);
}

TEST_F(DisturbPhotosTest, StopsBetweenPhotographs) {
  CancellationToken cancelled;
  cancelled.Cancel();
  const fs::path out = folder_ / "stopped";
  const Status status = DisturbPhotos(
      *ParseDisturbance("noise:5"), folder_ / "images", out, 1, &cancelled);
  EXPECT_EQ(status.code(), StatusCode::kInterrupted);
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(DisturbPhotosTest, WhatCannotBeDisturbedIsNamed) {
  const auto fault = [&](const std::string& text, const fs::path& images) {
    const Status status =
        DisturbPhotos(*ParseDisturbance(text), images, folder_ / "bad", 1);
    EXPECT_EQ(status.code(), StatusCode::kBadInput);
    return status.message();
  };
  EXPECT_THAT(fault("drop:1", folder_ / "images"), HasSubstr("left of 10"));
  EXPECT_THAT(fault("blur:1", folder_ / "images/p1.jpg"), HasSubstr("films"));
  EXPECT_THAT(fault("blur:1", folder_ / "none"), HasSubstr("none"));
  folder_.Write("useless/p.heic", "no photo");
  EXPECT_THAT(fault("blur:1", folder_ / "useless"), HasSubstr("left of 0"));
  folder_.Write("images/p2.jpg",
                photos::Encode(".tiff", photos::MakePicture(64, 48, 1)));
  EXPECT_THAT(fault("blur:1", folder_ / "images"), HasSubstr("TIFF"));
  EXPECT_THAT(fault("focal:2", folder_ / "images"), HasSubstr("p2.jpg"));
  Disturb("shuffle");
}

// What would leave the photographs as they are is no disturbance.
TEST_F(DisturbPhotosTest, AmountsThatChangeNothingAreErrors) {
  const auto fault = [&](const std::string& text) {
    const Status status = DisturbPhotos(
        *ParseDisturbance(text), folder_ / "images", folder_ / "bad", 1);
    EXPECT_EQ(status.code(), StatusCode::kBadInput) << text;
    return status.message();
  };
  EXPECT_THAT(fault("drop:0.04"), HasSubstr("drop:0.04 leaves out none of 10"));
  EXPECT_THAT(Disturb("drop:0.05"), SizeIs(9));
  EXPECT_THAT(fault("views:10"), HasSubstr("views:10 leaves out none of 10"));
  EXPECT_THAT(fault("views:99"), HasSubstr("views:99"));
  EXPECT_THAT(fault("focal:0.1"), HasSubstr("p1.jpg"));
  for (const std::string& name : names_) {
    folder_.Write("images/" + name, *WithExifBlock(Before(name), ""));
  }
  EXPECT_THAT(fault("focal:0.1"),
              HasSubstr("0.1 times the longest side; from 0.13 to 300"));
  EXPECT_THAT(Disturb("focal:0.14"), SizeIs(10));
  EXPECT_THAT(Disturb("focal:100"), SizeIs(10));
}

// Four photographs and four files that stage ingest does not use.
TEST_F(DisturbPhotosTest, FilesThatCannotBeUsedAreCopiedAndNotCounted) {
  for (int i = 5; i <= 10; ++i) fs::remove(folder_ / "images" / names_[i - 1]);
  names_.resize(4);
  std::set<std::string> useless;
  for (int i = 1; i <= 3; ++i) {
    const std::string name = "p" + std::to_string(i) + "b.heic";
    folder_.Write("images/" + name, "....ftypheic....");
    useless.insert(name);
  }
  // A photograph that was cut off.
  folder_.Write("images/p4b.jpg", Before("p4.jpg").substr(0, 900));
  useless.insert("p4b.jpg");
  // The photographs of the new folder, by their names.
  const auto disturb = [&](const std::string& text) {
    std::set<std::string> used;
    std::set<std::string> others;
    for (const std::string& file : Disturb(text)) {
      const std::string name = fs::path(file).filename().string();
      if (!useless.contains(name)) {
        used.insert(name);
        continue;
      }
      others.insert(name);
      EXPECT_EQ(After(file), Before(name)) << text;
    }
    EXPECT_EQ(others, useless) << text;
    EXPECT_THAT(used, IsSubsetOf(names_)) << text;
    return used.size();
  };
  EXPECT_EQ(disturb("noise:5"), 4u);
  EXPECT_NE(After("p4.jpg"), Before("p4.jpg"));
  const std::string noisy = After("p4.jpg");
  EXPECT_EQ(disturb("focal:2"), 4u);
  EXPECT_EQ(disturb("drop:0.5"), 2u);
  EXPECT_EQ(disturb("views:3"), 3u);
  EXPECT_EQ(disturb("shuffle"), 4u);
  EXPECT_TRUE(fs::exists(out_ / "p4b.jpg"));
  // They change nothing of what happens to the others.
  for (const std::string& name : useless) {
    fs::remove(folder_ / "images" / name);
  }
  Disturb("noise:5");
  EXPECT_EQ(After("p4.jpg"), noisy);
}

TEST_F(DisturbPhotosTest, PhotographsWithDamagedPixelsAreCopied) {
  // The file ends as it should, but some of its data are missing.
  const std::string jpeg = photos::MakeJpeg(64, 48, 5);
  const std::string cut = jpeg.substr(0, jpeg.size() - 100) + "\xff\xd9";
  folder_.Write("images/q.jpg", cut);
  const auto header = photos::ParsePhotoHeader(cut);
  ASSERT_TRUE(header.ok()) << header.status().message();
  ASSERT_TRUE(photos::CheckHeader(*header, {}).ok());
  ASSERT_FALSE(photos::DecodePhoto(cut, *header, {}).ok());
  Disturb("noise:5");
  EXPECT_EQ(After("q.jpg"), cut);
}

}  // namespace
}  // namespace freegs::stages
