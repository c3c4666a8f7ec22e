// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_exif.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "photos/photo_tiff.h"
#include "tests/photos/photo_test_files.h"

namespace freegs::photos {
namespace {

TEST(PhotoExifTest, ReadsTagsInBothByteOrders) {
  const ExifFields fields{.orientation = 8,
                          .make = "Maker Inc.",
                          .model = "M1",
                          .focal_mm_tenths = 42,
                          .focal_35mm = 26,
                          .focal_plane_per_cm = 5000,
                          .pixel_width = 4000,
                          .pixel_height = 3000};
  for (const bool little : {true, false}) {
    const ExifTags exif = ParseExif(MakeExif(fields, little));
    EXPECT_EQ(exif.orientation, 8);
    EXPECT_EQ(exif.make, "Maker Inc.");
    EXPECT_EQ(exif.model, "M1");
    EXPECT_DOUBLE_EQ(exif.focal_length_mm.value_or(0), 4.2);
    EXPECT_DOUBLE_EQ(exif.focal_length_35mm.value_or(0), 26);
    EXPECT_DOUBLE_EQ(exif.focal_plane_pixels_per_mm.value_or(0), 500);
    EXPECT_DOUBLE_EQ(exif.focal_plane_longest_side.value_or(0), 4000);
  }
}

// So libtiff writes it.
TEST(PhotoExifTest, TheExifDirectoryMayHaveATypeOfItsOwn) {
  std::string block = MakeExif({.focal_mm_tenths = 42});
  const std::string as_long = Bytes(0x8769, 2, true) + Bytes(4, 2, true);
  const size_t at = block.find(as_long);
  ASSERT_NE(at, std::string::npos);
  block.replace(at + 2, 2, Bytes(13, 2, true));
  EXPECT_DOUBLE_EQ(ParseExif(block).focal_length_mm.value_or(0), 4.2);
}

TEST(PhotoExifTest, DigitalZoom) {
  EXPECT_EQ(ParseExif(MakeExif({.focal_35mm = 26})).digital_zoom, 1);
  EXPECT_EQ(ParseExif(MakeExif({.zoom_tenths = 30})).digital_zoom, 3);
  // 0 says that there is none.
  std::string none = MakeExif({.zoom_tenths = 30});
  none.replace(none.size() - 8, 4, std::string(4, '\0'));
  EXPECT_EQ(ParseExif(none).digital_zoom, 1);
}

TEST(PhotoExifTest, MissingOrAbsurdTagsStayAtTheirDefaults) {
  for (const std::string& block : {std::string(),
                                   std::string("II"),
                                   std::string("no exif at all"),
                                   MakeExif({.orientation = 9}),
                                   MakeExif({})}) {
    const ExifTags exif = ParseExif(block);
    EXPECT_EQ(exif.orientation, 1);
    EXPECT_EQ(exif.make, "");
    EXPECT_FALSE(exif.focal_length_mm);
  }
}

TEST(PhotoExifTest, TextIsMadePrintable) {
  EXPECT_EQ(ParseExif(MakeExif({.make = "  A\nB\xff  "})).make, "A?B?");
}

TEST(PhotoExifTest, EveryTruncationIsSafe) {
  const std::string block = MakeExif({.orientation = 6,
                                      .make = "Maker",
                                      .model = "Model",
                                      .focal_mm_tenths = 42,
                                      .focal_35mm = 26});
  for (size_t size = 0; size <= block.size(); ++size) {
    const ExifTags exif = ParseExif(std::string_view(block).substr(0, size));
    EXPECT_TRUE(exif.orientation == 1 || exif.orientation == 6);
  }
}

TEST(PhotoExifTest, DirectoryPointerToItselfEnds) {
  std::string block = MakeExif({.orientation = 6});
  // The last tag of the main directory points to the EXIF directory.
  block.replace(8 + 2 + 12 + 8, 4, Bytes(8, 4, true));
  EXPECT_EQ(ParseExif(block).orientation, 6);
}

TEST(PhotoExifTest, ZeroDenominatorIsNoNumber) {
  std::string block = MakeExif({.focal_mm_tenths = 42});
  block.replace(block.size() - 4, 4, std::string(4, '\0'));
  EXPECT_FALSE(ParseExif(block).focal_length_mm);
}

TEST(FocalLengthPixelsTest, From35mmEquivalent) {
  // 36 x 24 mm film and a photo of that shape: the width is 36 mm.
  ExifTags exif;
  exif.focal_length_35mm = 36;
  EXPECT_NEAR(FocalLengthPixels(exif, 3000, 2000).value_or(0), 3000, 1e-9);
  EXPECT_NEAR(FocalLengthPixels(exif, 2000, 3000).value_or(0), 3000, 1e-9);
}

TEST(FocalLengthPixelsTest, FromSensorResolution) {
  ExifTags exif;
  exif.focal_length_mm = 10;
  EXPECT_FALSE(FocalLengthPixels(exif, 4000, 3000));
  exif.focal_plane_pixels_per_mm = 300;
  exif.focal_plane_longest_side = 4000;
  EXPECT_NEAR(FocalLengthPixels(exif, 4000, 3000).value_or(0), 3000, 1e-9);
  // A reduced copy keeps its tags.
  EXPECT_NEAR(FocalLengthPixels(exif, 2000, 1500).value_or(0), 1500, 1e-9);
}

TEST(FocalLengthPixelsTest, AbsurdValuesAreNoPrior) {
  ExifTags exif;
  EXPECT_FALSE(FocalLengthPixels(exif, 4000, 3000));
  exif.focal_length_35mm = 0.5;
  EXPECT_FALSE(FocalLengthPixels(exif, 4000, 3000));
  exif.focal_length_35mm = 65535;
  EXPECT_FALSE(FocalLengthPixels(exif, 4000, 3000));
}

}  // namespace
}  // namespace freegs::photos
