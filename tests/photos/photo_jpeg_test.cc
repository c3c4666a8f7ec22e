// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_jpeg.h"

#include <cstdio>
#include <cstdlib>
#include <jpeglib.h>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "photos/photo_header.h"
#include "tests/photos/photo_test_files.h"

namespace freegs::photos {
namespace {

using testing::HasSubstr;

// A picture of one colour with four components, as programs for print write it.
std::string MakeCmykJpeg(const std::vector<uint8_t>& ink, bool adobe) {
  constexpr int kSide = 40;
  jpeg_compress_struct info = {};
  jpeg_error_mgr errors = {};
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &buffer, &size);
  info.image_width = kSide;
  info.image_height = kSide;
  info.input_components = 4;
  info.in_color_space = JCS_CMYK;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, 100, TRUE);
  info.write_Adobe_marker = adobe ? TRUE : FALSE;
  jpeg_start_compress(&info, TRUE);
  std::vector<uint8_t> row;
  for (int x = 0; x < kSide; ++x) row.insert(row.end(), ink.begin(), ink.end());
  for (int y = 0; y < kSide; ++y) {
    uint8_t* pointer = row.data();
    jpeg_write_scanlines(&info, &pointer, 1);
  }
  jpeg_finish_compress(&info);
  jpeg_destroy_compress(&info);
  std::string bytes(reinterpret_cast<char*>(buffer), size);
  std::free(buffer);
  return bytes;
}

StatusOr<ImageU8> DecodeAny(std::string_view bytes) {
  FREEGS_ASSIGN_OR_RETURN(const PhotoHeader header, ParseJpegHeader(bytes));
  return DecodeJpeg(bytes, header);
}

TEST(PhotoJpegTest, CmykIsConverted) {
  // Full yellow ink and a fifth of black: dark yellow.
  for (const bool adobe : {false, true}) {
    const std::vector<uint8_t> ink =
        adobe ? std::vector<uint8_t>{255, 255, 0, 204}
              : std::vector<uint8_t>{0, 0, 255, 51};
    const std::string bytes = MakeCmykJpeg(ink, adobe);
    const auto header = ParseJpegHeader(bytes);
    ASSERT_TRUE(header.ok());
    EXPECT_FALSE(header->plain);
    const auto image = DecodeJpeg(bytes, *header);
    ASSERT_TRUE(image.ok()) << image.status().message();
    EXPECT_NEAR((*image)(20, 20, 0), 204, 2);
    EXPECT_NEAR((*image)(20, 20, 1), 204, 2);
    EXPECT_NEAR((*image)(20, 20, 2), 0, 2);
  }
}

TEST(PhotoJpegTest, TooManyScansAreRefused) {
  // The last scan of a progressive file, again and again.
  const std::string jpeg =
      Encode(".jpg", MakePicture(64, 48, 1), {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  const size_t scan = jpeg.rfind("\xff\xda");
  ASSERT_NE(scan, std::string::npos);
  const std::string last = jpeg.substr(scan, jpeg.size() - 2 - scan);
  std::string bomb = jpeg.substr(0, jpeg.size() - 2);
  for (int i = 0; i < 1000; ++i) bomb += last;
  bomb += "\xff\xd9";
  EXPECT_TRUE(DecodeAny(jpeg).ok());
  const auto image = DecodeAny(bomb);
  ASSERT_FALSE(image.ok());
  EXPECT_THAT(image.status().message(), HasSubstr("too many scans"));
}

TEST(PhotoJpegTest, EveryTruncationIsAnError) {
  const std::string jpeg = MakeJpeg(40, 33, 1);
  for (size_t size = 0; size + 2 < jpeg.size(); size += 7) {
    EXPECT_FALSE(DecodeAny(std::string_view(jpeg).substr(0, size)).ok())
        << size << " of " << jpeg.size();
  }
}

TEST(PhotoJpegTest, AnotherSizeThanTheHeadersIsRefused) {
  const std::string jpeg = MakeJpeg(40, 33, 1);
  auto header = ParseJpegHeader(jpeg);
  ASSERT_TRUE(header.ok());
  header->width = 41;
  const auto image = DecodeJpeg(jpeg, *header);
  ASSERT_FALSE(image.ok());
  EXPECT_THAT(image.status().message(), HasSubstr("two sizes"));
}

TEST(PhotoJpegTest, OddButHarmlessBytesAreAccepted) {
  const std::string jpeg = MakeJpeg(40, 33, 1);
  EXPECT_TRUE(DecodeAny(jpeg + "trailing bytes").ok());
  // A comment segment, and fill bytes before a marker.
  const std::string comment = "\xff\xfe" + Bytes(7, 2) + "hello";
  EXPECT_TRUE(
      DecodeAny(jpeg.substr(0, 2) + comment + "\xff\xff" + jpeg.substr(2))
          .ok());
}

}  // namespace
}  // namespace freegs::photos
