// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_header.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/photos/photo_test_files.h"

namespace freegs::photos {
namespace {

using testing::HasSubstr;

std::string MakeTiff(int width, int height) {
  return Encode(
      ".tif", MakePicture(width, height, 1), {cv::IMWRITE_TIFF_COMPRESSION, 1});
}

TEST(SniffFormatTest, TellsFormatsByContent) {
  EXPECT_EQ(*SniffFormat(MakeJpeg(40, 40, 1)), PhotoFormat::kJpeg);
  EXPECT_EQ(*SniffFormat(MakePng(40, 40, 1)), PhotoFormat::kPng);
  EXPECT_EQ(*SniffFormat(MakeTiff(40, 40)), PhotoFormat::kTiff);
}

TEST(SniffFormatTest, SaysWhatElseItIs) {
  const struct {
    std::string bytes;
    const char* message;
  } cases[] = {
      {"", "empty file"},
      {"this is a text, not a photo", "not an image"},
      {std::string("\0\0\0\x18", 4) + "ftypheic", "HEIC"},
      {std::string("RIFF\0\0\0\0WEBP", 12), "WebP"},
      {"GIF89a", "GIF"},
      {"BM", "BMP"},
      {"\xff", "not an image"},
      {std::string("II\x2a\0\x10\0\0\0CR\2\0", 12), "Canon raw"},
  };
  for (const auto& c : cases) {
    const auto format = SniffFormat(c.bytes);
    ASSERT_FALSE(format.ok()) << c.message;
    EXPECT_EQ(format.status().code(), StatusCode::kBadInput);
    EXPECT_THAT(format.status().message(), HasSubstr(c.message));
  }
}

TEST(PhotoHeaderTest, ReadsSizes) {
  for (const std::string& bytes :
       {MakeJpeg(50, 40, 1), MakePng(50, 40, 1), MakeTiff(50, 40)}) {
    const auto header = ParsePhotoHeader(bytes);
    ASSERT_TRUE(header.ok()) << header.status().message();
    EXPECT_EQ(header->width, 50);
    EXPECT_EQ(header->height, 40);
    EXPECT_EQ(header->bits, 8);
    EXPECT_EQ(header->samples, 3);
    EXPECT_FALSE(header->has_alpha);
    EXPECT_FALSE(header->truncated);
    EXPECT_GE(header->max_pixels, 50 * 40);
    EXPECT_EQ(header->exif.orientation, 1);
  }
}

TEST(PhotoHeaderTest, EveryTruncationIsNoticed) {
  for (const std::string& bytes :
       {MakeJpeg(50, 40, 1), MakePng(50, 40, 1), MakeTiff(50, 40)}) {
    for (size_t size = 0; size < bytes.size(); ++size) {
      const auto header =
          ParsePhotoHeader(std::string_view(bytes).substr(0, size));
      if (header.ok()) {
        EXPECT_TRUE(header->truncated) << size << " of " << bytes.size();
      }
    }
  }
}

TEST(PhotoHeaderTest, NoByteCrashesTheParsers) {
  const std::string exif =
      MakeExif({.orientation = 6, .make = "Maker", .focal_35mm = 28});
  for (const std::string& good :
       {WithExif(MakeJpeg(33, 40, 1), exif),
        WithPngChunk(MakePng(33, 40, 1), "eXIf", exif),
        MakeTiff(33, 40)}) {
    for (uint64_t trial = 0; trial < 3000; ++trial) {
      std::string bytes = good;
      const uint64_t changes = 1 + RandomIndex(5, trial, 0, 8);
      for (uint64_t i = 0; i < changes; ++i) {
        // Headers are where the parsers look: half the changes go there.
        const size_t range =
            i % 2 == 0 ? std::min<size_t>(bytes.size(), 300) : bytes.size();
        bytes[RandomIndex(5, trial, 2 * i + 1, range)] =
            static_cast<char>(RandomBits(5, trial, 2 * i + 2));
      }
      const auto header = ParsePhotoHeader(bytes);
      if (!header.ok()) {
        EXPECT_FALSE(header.status().message().empty());
      } else {
        EXPECT_GT(header->width, 0);
        EXPECT_GT(header->height, 0);
        EXPECT_GE(header->exif.orientation, 1);
        EXPECT_LE(header->exif.orientation, 8);
      }
    }
  }
}

TEST(PhotoHeaderTest, JpegMarkersWithinDataAreNoMarkers) {
  // A JPEG inside an EXIF segment has markers of its own, as thumbnails do.
  const std::string inner = MakeJpeg(16, 16, 2);
  const std::string exif = MakeExif({.orientation = 3}) + inner;
  const std::string bytes = WithExif(MakeJpeg(64, 48, 1), exif);
  const auto header = ParseJpegHeader(bytes);
  ASSERT_TRUE(header.ok());
  EXPECT_EQ(header->width, 64);
  EXPECT_EQ(header->exif.orientation, 3);
  EXPECT_FALSE(header->truncated);
  // Without its end, the inner picture's does not count.
  const auto cut =
      ParseJpegHeader(std::string_view(bytes).substr(0, bytes.size() - 2));
  ASSERT_TRUE(cut.ok());
  EXPECT_TRUE(cut->truncated);
}

TEST(PhotoHeaderTest, JpegMayBeFollowedByOtherData) {
  const auto header = ParseJpegHeader(MakeJpeg(64, 48, 1) + "trailing bytes");
  ASSERT_TRUE(header.ok());
  EXPECT_FALSE(header->truncated);
}

TEST(PhotoHeaderTest, PngSizeLieExceedsItsData) {
  const auto header =
      ParsePngHeader(WithPngSize(MakePng(64, 48, 1), 20000, 19000));
  ASSERT_TRUE(header.ok());
  EXPECT_EQ(header->width, 20000);
  EXPECT_LT(header->max_pixels, 20000.0 * 19000);
}

TEST(PhotoHeaderTest, PngChecksumsAreChecked) {
  std::string png = MakePng(64, 48, 1);
  png[kPngHeaderEnd + 20] ^= 1;
  const auto header = ParsePngHeader(png);
  ASSERT_FALSE(header.ok());
  EXPECT_THAT(header.status().message(), HasSubstr("checksum"));
}

TEST(PhotoHeaderTest, PngAlphaAndDepth) {
  cv::Mat alpha(40, 40, CV_16UC4, cv::Scalar(1, 2, 3, 4));
  const auto header = ParsePngHeader(Encode(".png", alpha));
  ASSERT_TRUE(header.ok());
  EXPECT_EQ(header->bits, 16);
  EXPECT_EQ(header->samples, 4);
  EXPECT_TRUE(header->has_alpha);
}

TEST(PhotoHeaderTest, PngWithGammaIsNotPlain) {
  const std::string png = MakePng(64, 48, 1);
  const struct {
    const char* type;
    std::string data;
    bool plain;
  } cases[] = {
      {"gAMA", Bytes(100000, 4), false},
      {"gAMA", Bytes(55556, 4), false},
      {"gAMA", Bytes(45455, 4), true},  // That of sRGB.
      {"gAMA", "", false},
      {"sRGB", Bytes(0, 1), true},
      {"cHRM", Bytes(31270, 4) + Bytes(32900, 4) + std::string(24, '\1'), true},
      {"iCCP", "not a profile", true},
  };
  for (const auto& c : cases) {
    const auto header = ParsePngHeader(WithPngChunk(png, c.type, c.data));
    ASSERT_TRUE(header.ok()) << header.status().message();
    EXPECT_EQ(header->plain, c.plain) << c.type << " " << c.data.size();
  }
  // The one of sRGB does not hide another one.
  const auto both = ParsePngHeader(WithPngChunk(
      WithPngChunk(png, "gAMA", Bytes(45455, 4)), "gAMA", Bytes(100000, 4)));
  ASSERT_TRUE(both.ok());
  EXPECT_FALSE(both->plain);
}

TEST(PhotoHeaderTest, PngWithAChunkThatDecodersRefuseIsNotPlain) {
  const std::string png = MakePng(64, 48, 1);
  const struct {
    std::string type;
    bool plain;
  } cases[] = {
      {"tEXt", true},
      {"zzZz", true},  // Nobody knows it, and everybody may skip it.
      {"ABCD", false},
      {"TEXt", false},
      {"tE1t", false},
      {"t\xe9xt", false},
      {"te[t", false},
      {std::string(4, '\0'), false},
  };
  for (const auto& c : cases) {
    const std::string chunk = PngChunk(c.type, "a");
    const auto before = ParsePngHeader(WithPngChunk(png, c.type, "a"));
    ASSERT_TRUE(before.ok()) << before.status().message();
    EXPECT_EQ(before->plain, c.plain) << c.type;
    const auto after = ParsePngHeader(std::string(png).insert(
        png.size() - PngChunk("IEND", "").size(), chunk));
    ASSERT_TRUE(after.ok()) << after.status().message();
    EXPECT_EQ(after->plain, c.plain) << c.type;
  }
}

TEST(PhotoHeaderTest, PngWithAChunkAmongItsDataIsNotPlain) {
  const std::string png = MakePng(64, 48, 1);
  const std::string text = PngChunk("tEXt", "a");
  const auto parts = ParsePngHeader(WithPngDataInTwo(png, ""));
  ASSERT_TRUE(parts.ok()) << parts.status().message();
  EXPECT_TRUE(parts->plain);
  const auto parted = ParsePngHeader(WithPngDataInTwo(png, text));
  ASSERT_TRUE(parted.ok()) << parted.status().message();
  EXPECT_FALSE(parted->plain);
}

TEST(PhotoHeaderTest, EssentialPngKeepsPixelsOnly) {
  const std::string png = MakePng(64, 48, 1);
  const std::string noisy = WithPngChunk(png, "tEXt", std::string("a\0b", 3));
  EXPECT_EQ(EssentialPng(noisy), EssentialPng(png));
  EXPECT_EQ(EssentialPng(noisy).find("tEXt"), std::string::npos);
}

TEST(PhotoHeaderTest, FloatAndBigTiffAreRefusedWithAdvice) {
  const cv::Mat picture(40, 40, CV_32FC3, cv::Scalar(0.1, 0.2, 0.3));
  const auto floats = ParseTiffHeader(Encode(".tif", picture));
  ASSERT_FALSE(floats.ok());
  EXPECT_THAT(floats.status().message(), HasSubstr("convert it"));
  const auto big =
      ParsePhotoHeader(std::string("II\x2b\0\x08\0\0\0\0\0\0\0", 12));
  ASSERT_FALSE(big.ok());
  EXPECT_THAT(big.status().message(), HasSubstr("BigTIFF"));
}

TEST(PhotoHeaderTest, TiffsThatAreNoPhotosAreRefused) {
  const std::string tiff = MakeTiff(40, 40);
  const std::string deep =
      Encode(".tif", cv::Mat(40, 40, CV_16UC4, cv::Scalar(1, 2, 3, 4)));
  constexpr int kNewSubfileType = 254;
  constexpr int kPhotometric = 262;
  constexpr int kDngVersion = 50706;
  const struct {
    std::string bytes;
    const char* message;
  } cases[] = {
      {WithTiffTag(tiff, kNewSubfileType, 1), "camera raw"},
      {WithTiffTag(tiff, kDngVersion, 1), "camera raw"},
      {WithTiffTag(tiff, kPhotometric, 32803), "camera raw"},
      {WithTiffTag(tiff, kPhotometric, 4), "other colours"},
      {WithTiffTag(tiff, kPhotometric, 8), "other colours"},
      {WithTiffTag(deep, kPhotometric, 5), "CMYK TIFF of 16 bits"},
  };
  for (const auto& c : cases) {
    EXPECT_THAT(ParsePhotoHeader(c.bytes).status().message(),
                HasSubstr(c.message));
  }
  // A page of several, and CMYK of 8 bits.
  EXPECT_TRUE(ParsePhotoHeader(WithTiffTag(tiff, kNewSubfileType, 2)).ok());
  const std::string four =
      Encode(".tif", cv::Mat(40, 40, CV_8UC4, cv::Scalar(1, 2, 3, 4)));
  EXPECT_TRUE(ParsePhotoHeader(WithTiffTag(four, kPhotometric, 5)).ok());
}

}  // namespace
}  // namespace freegs::photos
