// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_decode.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/photos/photo_test_files.h"

namespace freegs::photos {
namespace {

using testing::HasSubstr;

// Header and pixels in one call.
StatusOr<ImageU8> Decode(const std::string& bytes,
                         const PhotoDecodeOptions& options = {}) {
  FREEGS_ASSIGN_OR_RETURN(const PhotoHeader header, ParsePhotoHeader(bytes));
  FREEGS_RETURN_IF_ERROR(CheckHeader(header, options));
  return DecodePhoto(bytes, header, options);
}

std::string Failure(const std::string& bytes,
                    const PhotoDecodeOptions& options = {}) {
  const auto image = Decode(bytes, options);
  if (image.ok()) return "decoded";
  EXPECT_EQ(image.status().code(), StatusCode::kBadInput);
  return image.status().message();
}

TEST(PhotoDecodeTest, LosslessFormatsGiveTheSamePixels) {
  const cv::Mat picture = MakePicture(70, 50, 3);
  const ImageU8 expected = RgbOf(picture);
  for (const char* suffix : {".png", ".tif"}) {
    const auto image = Decode(Encode(suffix, picture));
    ASSERT_TRUE(image.ok()) << image.status().message();
    EXPECT_EQ(LargestDifference(*image, expected), 0) << suffix;
  }
}

TEST(PhotoDecodeTest, JpegAgreesWithOpenCv) {
  for (const int progressive : {0, 1}) {
    const std::string bytes =
        Encode(".jpg",
               MakePicture(70, 50, 3),
               {cv::IMWRITE_JPEG_PROGRESSIVE, progressive});
    const cv::Mat buffer(1,
                         static_cast<int>(bytes.size()),
                         CV_8UC1,
                         const_cast<char*>(bytes.data()));
    const auto image = Decode(bytes);
    ASSERT_TRUE(image.ok()) << image.status().message();
    EXPECT_LE(LargestDifference(*image,
                                RgbOf(cv::imdecode(buffer, cv::IMREAD_COLOR))),
              1);
  }
}

TEST(PhotoDecodeTest, GreyIsRepeated) {
  cv::Mat grey;
  cv::cvtColor(MakePicture(40, 40, 3), grey, cv::COLOR_BGR2GRAY);
  for (const char* suffix : {".png", ".tif", ".jpg"}) {
    const auto image = Decode(Encode(suffix, grey));
    ASSERT_TRUE(image.ok()) << suffix;
    for (size_t i = 0; i < image->num_pixels(); ++i) {
      ASSERT_EQ(image->data()[3 * i], image->data()[3 * i + 1]);
      ASSERT_EQ(image->data()[3 * i], image->data()[3 * i + 2]);
      ASSERT_NEAR(image->data()[3 * i], grey.data[i], 8);
    }
  }
}

TEST(PhotoDecodeTest, SixteenBitsAreScaledNotStretched) {
  // Values of a narrow range must stay what they are.
  cv::Mat deep(40, 40, CV_16UC3, cv::Scalar(0, 32768, 65535));
  deep.at<cv::Vec3w>(0, 0) = {128, 129, 257};
  for (const char* suffix : {".png", ".tif"}) {
    const auto image = Decode(Encode(suffix, deep));
    ASSERT_TRUE(image.ok()) << suffix;
    EXPECT_EQ((*image)(5, 5, 0), 255);
    EXPECT_EQ((*image)(5, 5, 1), 128);
    EXPECT_EQ((*image)(5, 5, 2), 0);
    EXPECT_EQ((*image)(0, 0, 0), 1);
    EXPECT_EQ((*image)(0, 0, 1), 1);
    EXPECT_EQ((*image)(0, 0, 2), 0);
  }
  cv::Mat grey(40, 40, CV_16UC1, cv::Scalar(30 * 257));
  for (const char* suffix : {".png", ".tif"}) {
    const auto image = Decode(Encode(suffix, grey));
    ASSERT_TRUE(image.ok()) << suffix;
    EXPECT_EQ((*image)(5, 5, 1), 30);
  }
}

TEST(PhotoDecodeTest, AlphaIsLaidOverTheBackground) {
  const struct {
    int alpha;
    int white;
    int black;
  } cases[] = {{255, 100, 100}, {0, 255, 0}, {128, 177, 50}};
  for (const auto& c : cases) {
    const cv::Mat shallow(40, 40, CV_8UC4, cv::Scalar(100, 100, 100, c.alpha));
    const cv::Mat deep(
        40, 40, CV_16UC4, cv::Scalar(100, 100, 100, c.alpha) * 257);
    for (const auto& [suffix, picture] : {std::pair{".png", shallow},
                                          {".png", deep},
                                          {".tif", shallow},
                                          {".tif", deep}}) {
      const std::string bytes = Encode(suffix, picture);
      const auto white = Decode(bytes, {.background = "white"});
      const auto black = Decode(bytes, {.background = "black"});
      ASSERT_TRUE(white.ok()) << white.status().message();
      EXPECT_NEAR((*white)(3, 3, 0), c.white, 1) << suffix << picture.depth();
      EXPECT_NEAR((*black)(3, 3, 2), c.black, 1) << suffix << picture.depth();
    }
  }
}

TEST(PhotoDecodeTest, UncommonPngKinds) {
  constexpr int kSide = 32;
  const auto rows = [](const std::string& row) {
    std::string all;
    for (int y = 0; y < kSide; ++y) all += std::string(1, '\0') + row;
    return all;
  };
  const std::string palette = PngChunk("PLTE", "\x0a\x14\x1e\x28\x32\x3c");
  const std::string index_one(kSide, '\x01');
  const struct {
    const char* what;
    std::string bytes;
    int red;
    int blue;
  } cases[] = {
      {"palette", RawPng(kSide, kSide, 8, 3, rows(index_one), palette), 40, 60},
      {"palette of 1 bit",
       RawPng(kSide, kSide, 1, 3, rows("\xff\xff\xff\xff"), palette),
       40,
       60},
      {"palette with a transparent colour",
       RawPng(kSide,
              kSide,
              8,
              3,
              rows(index_one),
              palette + PngChunk("tRNS", std::string("\xff\x00", 2))),
       255,
       255},
      {"grey of 1 bit",
       RawPng(kSide, kSide, 1, 0, rows("\xff\xff\xff\xff")),
       255,
       255},
      {"grey with a transparent level",
       RawPng(kSide,
              kSide,
              8,
              0,
              rows(std::string(kSide, 'd')),
              PngChunk("tRNS", std::string("\0d", 2))),
       255,
       255},
      {"grey with another transparent level",
       RawPng(kSide,
              kSide,
              8,
              0,
              rows(std::string(kSide, 'd')),
              PngChunk("tRNS", std::string("\0e", 2))),
       100,
       100},
      {"grey of 2 bits with a transparent level",
       RawPng(kSide,
              kSide,
              2,
              0,
              rows("UUUUUUUU"),
              PngChunk("tRNS", std::string("\0\1", 2))),
       255,
       255},
      {"grey of 16 bits with a transparent level",
       RawPng(kSide,
              kSide,
              16,
              0,
              rows(std::string(2 * kSide, 'd')),
              PngChunk("tRNS", "dd")),
       255,
       255},
      {"grey of 2 bits", RawPng(kSide, kSide, 2, 0, rows("UUUUUUUU")), 85, 85},
      {"grey of 4 bits",
       RawPng(kSide, kSide, 4, 0, rows("3333333333333333")),
       51,
       51},
      {"grey with alpha",
       RawPng(kSide, kSide, 8, 4, rows([] {
                std::string row;
                for (int x = 0; x < kSide; ++x) row += std::string("d\x00", 2);
                return row;
              }())),
       255,
       255},
  };
  for (const auto& c : cases) {
    const auto header = ParsePhotoHeader(c.bytes);
    ASSERT_TRUE(header.ok()) << c.what << header.status().message();
    EXPECT_FALSE(IsPlainPhoto(*header)) << c.what;
    const auto image = Decode(c.bytes, {.background = "white"});
    ASSERT_TRUE(image.ok()) << c.what << ": " << image.status().message();
    EXPECT_EQ((*image)(3, 3, 0), c.red) << c.what;
    EXPECT_EQ((*image)(3, 3, 2), c.blue) << c.what;
  }
}

TEST(PhotoDecodeTest, TiffAlphaIsAppliedOnceWhateverItsKind) {
  const struct {
    int kind;  // 1 already multiplied, 2 not.
    int white;
    int black;
  } cases[] = {{1, 227, 100}, {2, 177, 50}};
  for (const auto& c : cases) {
    const cv::Mat shallow(40, 40, CV_8UC4, cv::Scalar(100, 100, 100, 128));
    const cv::Mat deep(40, 40, CV_16UC4, cv::Scalar(100, 100, 100, 128) * 257);
    for (const cv::Mat& picture : {shallow, deep}) {
      const std::string bytes =
          WithTiffTag(Encode(".tif", picture), 338, c.kind);
      const auto white = Decode(bytes, {.background = "white"});
      const auto black = Decode(bytes, {.background = "black"});
      ASSERT_TRUE(white.ok()) << white.status().message();
      EXPECT_NEAR((*white)(3, 3, 0), c.white, 1)
          << c.kind << " " << picture.depth();
      EXPECT_NEAR((*black)(3, 3, 2), c.black, 1)
          << c.kind << " " << picture.depth();
    }
  }
}

TEST(PhotoDecodeTest, KindsOfTiffs) {
  const struct {
    const char* what;
    RawTiffFields fields;
    std::vector<int> pixel;
    std::vector<int> rgb;
  } cases[] = {
      {"grey", {}, {30}, {30, 30, 30}},
      {"grey of 1 bit", {.bits = 1}, {1}, {255, 255, 255}},
      {"grey of 16 bits", {.bits = 16}, {30 * 257}, {30, 30, 30}},
      {"0 is white", {.photometric = 0}, {30}, {225, 225, 225}},
      {"RGB", {.photometric = 2}, {10, 20, 30}, {10, 20, 30}},
      {"planes", {.photometric = 2, .planar = 2}, {10, 20, 30}, {10, 20, 30}},
      {"RGB of 16 bits",
       {.bits = 16, .photometric = 2},
       {10 * 257, 20 * 257, 30 * 257},
       {10, 20, 30}},
      {"alpha", {.photometric = 2, .extra = 2}, {9, 9, 9, 0}, {255, 255, 255}},
      {"alpha by default", {.photometric = 2}, {9, 9, 9, 0}, {255, 255, 255}},
      {"something else than alpha",
       {.photometric = 2, .extra = 0},
       {10, 20, 30, 0},
       {10, 20, 30}},
      {"something else than alpha, of 16 bits",
       {.bits = 16, .photometric = 2, .extra = 0},
       {10 * 257, 20 * 257, 30 * 257, 0},
       {10, 20, 30}},
      {"CMYK", {.photometric = 5}, {255, 0, 0, 0}, {0, 255, 255}},
  };
  for (const auto& c : cases) {
    const auto image =
        Decode(RawTiff(c.fields, c.pixel), {.background = "white"});
    ASSERT_TRUE(image.ok()) << c.what << ": " << image.status().message();
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ((*image)(0, 0, k), c.rgb[k]) << c.what;
      EXPECT_EQ((*image)(39, 39, k), c.rgb[k]) << c.what;
    }
  }
}

// The decoder would read some of them wrongly without a word.
TEST(PhotoDecodeTest, OtherKindsOfTiffsAreRefusedWithAdvice) {
  const struct {
    RawTiffFields fields;
    std::vector<int> pixel;
    const char* message;
  } cases[] = {
      {{.bits = 16, .photometric = 2, .planar = 2},
       {1, 2, 3},
       "16 bits with a plane for each colour"},
      {{.bits = 16, .photometric = 0}, {7}, "16 bits in which 0 is white"},
      {{.bits = 4}, {7}, "4-bit samples"},
      {{.photometric = 2, .extra = 0},
       {1, 2, 3, 4, 5},
       "(RGB, bits per sample: 8, samples per pixel: 5)"},
      {{.extra = 2},
       {1, 2},
       "(grey, bits per sample: 8, samples per pixel: 2)"},
      {{.bits = 1, .photometric = 3}, {1}, "(palette, bits per sample: 1"},
      {{.bits = 16, .photometric = 6}, {1, 2, 3}, "(YCbCr"},
  };
  for (const auto& c : cases) {
    const std::string message = Failure(RawTiff(c.fields, c.pixel));
    EXPECT_THAT(message, HasSubstr(c.message));
    EXPECT_THAT(message, HasSubstr("convert it"));
  }
}

// Where the picture's corners (top left, top right, bottom right, bottom left)
// lie after it is turned upright; EXIF's definition read off its figure.
TEST(PhotoDecodeTest, OrientationTable) {
  // Corners of the stored picture: red, green, blue, white.
  cv::Mat stored(48, 64, CV_8UC3, cv::Scalar(90, 90, 90));
  const cv::Rect corners[] = {
      {0, 0, 16, 16}, {48, 0, 16, 16}, {48, 32, 16, 16}, {0, 32, 16, 16}};
  const cv::Scalar colours[] = {
      {0, 0, 255}, {0, 255, 0}, {255, 0, 0}, {255, 255, 255}};
  for (int i = 0; i < 4; ++i) stored(corners[i]).setTo(colours[i]);

  // Upright corners clockwise from the top left, by stored corner.
  const char* const expected[] = {
      "RGBW", "GRWB", "BWRG", "WBGR", "RWBG", "WRGB", "BGRW", "GBWR"};
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const std::string exif = MakeExif({.orientation = orientation});
    const std::string tiff =
        WithTiffTag(Encode(".tif", stored), 274, orientation);

    for (const std::string& bytes :
         {WithExif(Encode(".jpg", stored, {cv::IMWRITE_JPEG_QUALITY, 100}),
                   exif),
          WithPngChunk(Encode(".png", stored), "eXIf", exif),
          tiff}) {
      const auto header = ParsePhotoHeader(bytes);
      ASSERT_TRUE(header.ok());
      EXPECT_EQ(header->exif.orientation, orientation);
      EXPECT_EQ(IsPlainPhoto(*header),
                orientation == 1 && header->format != PhotoFormat::kTiff);
      const auto image = Decode(bytes);
      ASSERT_TRUE(image.ok()) << image.status().message();
      EXPECT_EQ(image->width(), orientation >= 5 ? 48 : 64);
      EXPECT_EQ(image->height(), orientation >= 5 ? 64 : 48);
      const int right = image->width() - 8;
      const int bottom = image->height() - 8;
      const std::pair<int, int> points[] = {
          {8, 8}, {right, 8}, {right, bottom}, {8, bottom}};
      std::string found;
      for (const auto& [x, y] : points) {
        const int red = (*image)(x, y, 0) > 150;
        const int green = (*image)(x, y, 1) > 150;
        const int blue = (*image)(x, y, 2) > 150;
        found += red + green + blue == 3 ? 'W'
                 : red                   ? 'R'
                 : green                 ? 'G'
                 : blue                  ? 'B'
                                         : '?';
      }
      EXPECT_EQ(found, expected[orientation - 1])
          << FormatName(header->format) << " orientation " << orientation;
    }
  }
}

TEST(PhotoDecodeTest, HostileFilesAreRefusedBeforeDecoding) {
  const std::string jpeg = MakeJpeg(64, 48, 1);
  const std::string png = MakePng(64, 48, 1);
  const std::string tiff =
      Encode(".tif", MakePicture(64, 48, 1), {cv::IMWRITE_TIFF_COMPRESSION, 1});
  const std::string lzw =
      Encode(".tif", MakePicture(64, 48, 1), {cv::IMWRITE_TIFF_COMPRESSION, 5});
  const struct {
    const char* what;
    std::string bytes;
    const char* message;
  } cases[] = {
      {"empty", "", "empty file"},
      {"text", "hello, world\n", "not an image"},
      {"half a JPEG", jpeg.substr(0, jpeg.size() / 2), "truncated JPEG"},
      {"JPEG without its end",
       jpeg.substr(0, jpeg.size() - 2),
       "truncated JPEG"},
      {"JPEG header only", jpeg.substr(0, 30), "truncated JPEG"},
      {"half a PNG", png.substr(0, png.size() / 2), "truncated PNG"},
      {"PNG without its end", png.substr(0, png.size() - 12), "truncated PNG"},
      {"JPEG of 40000 x 1", WithJpegSize(jpeg, 40000, 1), "40000 x 1"},
      {"JPEG of 60000 x 60000",
       WithJpegSize(jpeg, 60000, 60000),
       "more than the limit"},
      {"JPEG of 19000 x 19000",
       WithJpegSize(jpeg, 19000, 19000),
       "more than its data can hold"},
      {"JPEG of 300 x 300", WithJpegSize(jpeg, 300, 300), "damaged JPEG"},
      {"JPEG of no height", WithJpegSize(jpeg, 64, 0), "gives no size"},
      {"JPEG of 65500 x 65500, then of 64 x 48",
       WithSecondJpegFrame(WithJpegSize(jpeg, 65500, 65500), 64, 48),
       "two frame headers"},
      {"JPEG of 64 x 48, then of 65500 x 65500",
       WithSecondJpegFrame(jpeg, 65500, 65500),
       "two frame headers"},
      {"PNG of 60000 x 60000",
       WithPngSize(png, 60000, 60000),
       "more than the limit"},
      {"PNG of 2^31 x 2^31",
       WithPngSize(png, 1U << 31, 1U << 31),
       "more than the limit"},
      {"PNG of 20000 x 19000",
       WithPngSize(png, 20000, 19000),
       "more than its data can hold"},
      {"TIFF of 60000 x 60000",
       WithTiffSize(tiff, 60000, 60000),
       "more than the limit"},
      {"TIFF of 20000 x 19000",
       WithTiffSize(tiff, 20000, 19000),
       "more than its data can hold"},
      {"compressed TIFF of 20000 x 19000",
       WithTiffSize(lzw, 20000, 19000),
       "more than its data can hold"},
      {"PNG of 128 x 64", WithPngSize(png, 128, 64), "damaged PNG"},
      {"PNG of no width", WithPngSize(png, 0, 10), "damaged PNG header"},
      {"1 x 1", MakePng(1, 1, 1), "only 1 x 1 pixels"},
      {"31 x 100", MakeJpeg(31, 100, 1), "shorter than 32"},
  };
  for (const auto& c : cases) {
    EXPECT_THAT(Failure(c.bytes), HasSubstr(c.message)) << c.what;
  }
  EXPECT_EQ(Failure(MakeJpeg(32, 32, 1)), "decoded");
}

TEST(PhotoDecodeTest, JpegCutWithAnEndAddedIsDamaged) {
  const std::string jpeg = MakeJpeg(200, 150, 1);
  EXPECT_THAT(Failure(jpeg.substr(0, jpeg.size() * 2 / 3) + "\xff\xd9"),
              HasSubstr("damaged JPEG"));
}

TEST(PhotoDecodeTest, TruncatedTiffIsRefused) {
  const std::string tiff =
      Encode(".tif", MakePicture(64, 48, 1), {cv::IMWRITE_TIFF_COMPRESSION, 1});
  EXPECT_THAT(Failure(tiff.substr(0, tiff.size() / 2)),
              HasSubstr("truncated TIFF"));
  EXPECT_THAT(Failure(tiff.substr(0, tiff.size() - 40)),
              HasSubstr("truncated TIFF"));
}

TEST(PhotoDecodeTest, LimitsAreOptions) {
  const std::string jpeg = MakeJpeg(200, 150, 1);
  EXPECT_THAT(Failure(jpeg, {.max_megapixels = 0.02}),
              HasSubstr("0.02 megapixels; reduce the photo"));
  EXPECT_THAT(Failure(jpeg,
                      {.max_megapixels = 0.02,
                       .max_megapixels_option = "ingest.max_megapixels"}),
              HasSubstr("0.02 megapixels (ingest.max_megapixels)"));
  EXPECT_THAT(Failure(jpeg, {.min_side = 151}), HasSubstr("shorter than 151"));
  EXPECT_EQ(Failure(MakePng(1, 1, 1), {.min_side = 1}), "decoded");
  EXPECT_FALSE(PhotoDecodeOptions{.max_megapixels = 0}.Check().ok());
  EXPECT_FALSE(PhotoDecodeOptions{.min_side = 0}.Check().ok());
  EXPECT_FALSE(PhotoDecodeOptions{.background = "pink"}.Check().ok());
  EXPECT_TRUE(PhotoDecodeOptions().Check().ok());
}

TEST(PhotoDecodeTest, SidesThatLibpngCannotReadAreRefused) {
  PhotoHeader header = *ParsePhotoHeader(MakePng(40, 40, 1));
  header.max_pixels = 1e9;
  header.width = 1'000'000;
  EXPECT_TRUE(CheckHeader(header, {}).ok());
  header.width = 1'000'001;
  EXPECT_THAT(CheckHeader(header, {}).message(),
              HasSubstr("longer than 1000000 on a side"));
}

TEST(PhotoDecodeTest, FlippedBytesNeverCrash) {
  const std::string exif = MakeExif({.orientation = 6});
  const cv::Mat alpha(40, 40, CV_8UC4, cv::Scalar(1, 2, 3, 40));
  for (const std::string& good : {WithExif(MakeJpeg(40, 33, 1), exif),
                                  MakePng(40, 33, 1),
                                  Encode(".tif", MakePicture(40, 33, 1)),
                                  Encode(".tif", alpha)}) {
    for (uint64_t trial = 0; trial < 300; ++trial) {
      std::string bytes = good;
      const size_t range =
          trial % 2 == 0 ? std::min<size_t>(bytes.size(), 400) : bytes.size();
      bytes[RandomIndex(9, trial, 0, range)] =
          static_cast<char>(RandomBits(9, trial, 1));
      const auto image = Decode(bytes, {.max_megapixels = 1});
      if (image.ok()) {
        EXPECT_EQ(image->channels(), 3);
      }
    }
  }
}

TEST(PhotoDecodeTest, PlainPhotosNeedNoReencoding) {
  cv::Mat grey(40, 40, CV_8UC1, cv::Scalar(9));
  cv::Mat deep(40, 40, CV_16UC3, cv::Scalar(9));
  cv::Mat alpha(40, 40, CV_8UC4, cv::Scalar(9));
  const struct {
    std::string bytes;
    bool plain;
  } cases[] = {{MakeJpeg(40, 40, 1), true},
               {MakePng(40, 40, 1), true},
               {Encode(".png", grey), true},
               {Encode(".jpg", grey), true},
               {Encode(".tif", grey), false},
               {Encode(".png", deep), false},
               {Encode(".png", alpha), false}};
  for (const auto& c : cases) {
    const auto header = ParsePhotoHeader(c.bytes);
    ASSERT_TRUE(header.ok());
    EXPECT_EQ(IsPlainPhoto(*header), c.plain);
  }
}

}  // namespace
}  // namespace freegs::photos
