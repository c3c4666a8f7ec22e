// SPDX-License-Identifier: BSD-3-Clause

#include "stages/disturb/exif_block.h"

#include <string>

#include <gtest/gtest.h>

#include "photos/photo_header.h"
#include "tests/photos/photo_test_files.h"

namespace freegs::stages {
namespace {

using photos::ExifFields;
using photos::MakeExif;
using photos::MakeJpeg;
using photos::MakePng;
using photos::ParsePhotoHeader;

TEST(ExifBlockTest, GoesInAndComesOut) {
  const std::string block = MakeExif({.orientation = 6, .make = "M"});
  const std::string other = MakeExif({.orientation = 3, .model = "A1"});
  for (const std::string& file : {MakeJpeg(40, 30, 1), MakePng(40, 30, 1)}) {
    EXPECT_EQ(ExifBlockOf(file), "");
    const auto with = WithExifBlock(file, block);
    ASSERT_TRUE(with.ok()) << with.status().message();
    EXPECT_EQ(ExifBlockOf(*with), block);
    EXPECT_EQ(ParsePhotoHeader(*with)->exif.orientation, 6);
    EXPECT_FALSE(ParsePhotoHeader(*with)->truncated);
    const auto replaced = WithExifBlock(*with, other);
    ASSERT_TRUE(replaced.ok()) << replaced.status().message();
    EXPECT_EQ(ExifBlockOf(*replaced), other);
    const auto without = WithExifBlock(*replaced, "");
    ASSERT_TRUE(without.ok()) << without.status().message();
    EXPECT_EQ(*without, file);
  }
}

TEST(ExifBlockTest, WhatLiesBetweenSegmentsIsSkipped) {
  const std::string block = MakeExif({.orientation = 6});
  const std::string file = photos::WithExif(MakeJpeg(40, 30, 1), block);
  for (const char* between : {"\xff", "\xff\xff", "\xff\x01", "\xff\xd0"}) {
    std::string odd = file;
    odd.insert(2, between);
    ASSERT_EQ(ParsePhotoHeader(odd)->exif.orientation, 6);
    EXPECT_EQ(ExifBlockOf(odd), block);
    const auto without = WithExifBlock(odd, "");
    ASSERT_TRUE(without.ok()) << without.status().message();
    EXPECT_EQ(ExifBlockOf(*without), "");
    EXPECT_EQ(ParsePhotoHeader(*without)->exif.orientation, 1);
  }
}

TEST(ExifBlockTest, FocalLengthsComeBack) {
  photos::ExifTags tags;
  tags.orientation = 8;
  tags.make = "Odd";
  tags.model = "M 1";
  for (const double focal : {0.5, 1.0, 1.2345, 3.0}) {
    const photos::ExifTags read =
        photos::ParseExif(ExifBlockWithFocal(tags, focal));
    EXPECT_EQ(read.orientation, 8);
    EXPECT_EQ(read.make, "Odd");
    EXPECT_EQ(read.model, "M 1");
    for (const auto& [width, height] : {std::pair(640, 480), {30, 4000}}) {
      const double longest = std::max(width, height);
      EXPECT_NEAR(photos::FocalLengthPixels(read, width, height).value_or(0),
                  focal * longest,
                  1e-5 * longest);
    }
  }
}

TEST(ExifBlockTest, OtherAndDamagedFilesAreRefused) {
  EXPECT_FALSE(WithExifBlock("no photo", "MM").ok());
  EXPECT_FALSE(WithExifBlock("\x89PNG\r\n\x1a\n", "MM").ok());
  const std::string jpeg = MakeJpeg(40, 30, 1);
  EXPECT_FALSE(WithExifBlock(jpeg, std::string(70000, 'x')).ok());
  EXPECT_EQ(ExifBlockOf("no photo"), "");
  for (const std::string& whole :
       {photos::WithExif(jpeg, MakeExif({.orientation = 6})),
        *WithExifBlock(MakePng(40, 30, 1), MakeExif({.orientation = 6}))}) {
    for (size_t size = 0; size < whole.size(); ++size) {
      const std::string cut = whole.substr(0, size);
      EXPECT_LE(ExifBlockOf(cut).size(), size);
      (void)WithExifBlock(cut, "MM");
    }
  }
}

}  // namespace
}  // namespace freegs::stages
