// SPDX-License-Identifier: BSD-3-Clause
// Image files: exact round trips, and no crash on anything else.

#include "core/io/image_io.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/files.h"
#include "core/random.h"
#include "tests/temporary_folder.h"

namespace freegs {
namespace {

namespace fs = std::filesystem;

ImageU8 Noise(int width, int height, int channels) {
  ImageU8 image(width, height, channels);
  for (size_t i = 0; i < image.size(); ++i) {
    image.data()[i] = static_cast<uint8_t>(RandomIndex(1, 2, i, 256));
  }
  return image;
}

bool Same(const ImageU8& a, const ImageU8& b) {
  return a.width() == b.width() && a.height() == b.height() &&
         a.channels() == b.channels() &&
         std::equal(a.data(), a.data() + a.size(), b.data());
}

TEST(ImageTest, LayoutIsRowsOfInterleavedChannels) {
  ImageU8 image(3, 2, 2, 7);
  EXPECT_EQ(image.size(), 12u);
  EXPECT_EQ(image.num_pixels(), 6u);
  image(2, 1, 1) = 9;
  EXPECT_EQ(image.data()[11], 9);
  EXPECT_EQ(image.row(1) + 5, image.data() + 11);
  EXPECT_TRUE(ImageU8().empty());
}

TEST(ImageIoTest, LosslessFormatsRoundTrip) {
  const TemporaryFolder folder;
  const ImageU8 image = Noise(31, 17, 3);
  for (const char* name : {"a.png", "a.tif", "a.tiff"}) {
    ASSERT_TRUE(WriteImage(folder / name, image).ok()) << name;
    const StatusOr<ImageU8> read = ReadRgb(folder / name);
    ASSERT_TRUE(read.ok()) << name;
    EXPECT_TRUE(Same(*read, image)) << name;
  }
}

TEST(ImageIoTest, ChannelsAreRgb) {
  const TemporaryFolder folder;
  ImageU8 red(4, 4, 3);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 4; ++x) red(x, y, 0) = 255;
  }
  ASSERT_TRUE(WriteImage(folder / "red.jpg", red).ok());
  const StatusOr<ImageU8> read = ReadRgb(folder / "red.jpg");
  ASSERT_TRUE(read.ok());
  EXPECT_GT((*read)(1, 1, 0), 240);
  EXPECT_LT((*read)(1, 1, 2), 15);
}

TEST(ImageIoTest, GreyIsRepeatedAndAlphaDropped) {
  const TemporaryFolder folder;
  const ImageU8 grey = Noise(5, 4, 1);
  ASSERT_TRUE(WriteImage(folder / "grey.png", grey).ok());
  const StatusOr<ImageU8> from_grey = ReadRgb(folder / "grey.png");
  ASSERT_TRUE(from_grey.ok());
  EXPECT_EQ(from_grey->channels(), 3);
  EXPECT_EQ((*from_grey)(2, 3, 0), grey(2, 3));
  EXPECT_EQ((*from_grey)(2, 3, 2), grey(2, 3));

  const ImageU8 rgba = Noise(5, 4, 4);
  ASSERT_TRUE(WriteImage(folder / "rgba.png", rgba).ok());
  const StatusOr<ImageU8> from_rgba = ReadRgb(folder / "rgba.png");
  ASSERT_TRUE(from_rgba.ok());
  EXPECT_EQ(from_rgba->channels(), 3);
  EXPECT_EQ((*from_rgba)(4, 1, 0), rgba(4, 1, 0));
}

TEST(ImageIoTest, LabelsKeepSixteenBits) {
  const TemporaryFolder folder;
  ImageU16 labels(7, 5, 1);
  for (size_t i = 0; i < labels.size(); ++i) {
    labels.data()[i] = static_cast<uint16_t>(i * 1871);
  }
  ASSERT_TRUE(WriteLabels(folder / "l.png", labels).ok());
  const StatusOr<ImageU16> read = ReadLabels(folder / "l.png");
  ASSERT_TRUE(read.ok());
  EXPECT_TRUE(
      std::equal(labels.data(), labels.data() + labels.size(), read->data()));

  // JPEG would keep eight bits and change them.
  ASSERT_TRUE(WriteLabels(folder / "l.jpg", labels).ok());
  const StatusOr<ImageU16> odd = ReadLabels(folder / "l.jpg");
  ASSERT_TRUE(odd.ok());
  EXPECT_TRUE(
      std::equal(labels.data(), labels.data() + labels.size(), odd->data()));

  const ImageU8 narrow = Noise(7, 5, 1);
  ASSERT_TRUE(WriteImage(folder / "n.png", narrow).ok());
  EXPECT_EQ((*ReadLabels(folder / "n.png"))(3, 2), narrow(3, 2));
  ASSERT_TRUE(WriteImage(folder / "c.png", Noise(7, 5, 3)).ok());
  EXPECT_EQ(ReadLabels(folder / "c.png").status().code(),
            StatusCode::kBadInput);
  // Its content decides, whatever it is called.
  ASSERT_TRUE(WriteImage(folder / "n.tif", narrow).ok());
  std::filesystem::rename(folder / "n.tif", folder / "t.png");
  EXPECT_THAT(ReadLabels(folder / "t.png").status().message(),
              testing::HasSubstr("TIFF"));
}

TEST(ImageIoTest, LabelsOfFewerBitsAreAsStored) {
  // A grey PNG of 4 bits: 0, 1, 7, 15.
  constexpr uint8_t kPng[] = {
      0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d,
      0x49, 0x48, 0x44, 0x52, 0x00, 0x00, 0x00, 0x04, 0x00, 0x00, 0x00, 0x01,
      0x04, 0x00, 0x00, 0x00, 0x00, 0x19, 0xa7, 0xbd, 0x10, 0x00, 0x00, 0x00,
      0x0b, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0x60, 0xac, 0x07, 0x00,
      0x00, 0x84, 0x00, 0x81, 0xa7, 0xd7, 0x71, 0x01, 0x00, 0x00, 0x00, 0x00,
      0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  const TemporaryFolder folder;
  WriteText(folder / "l.png", std::string(std::begin(kPng), std::end(kPng)));
  const StatusOr<ImageU16> labels = ReadLabels(folder / "l.png");
  ASSERT_TRUE(labels.ok()) << labels.status().message();
  EXPECT_THAT(std::vector<int>(labels->data(), labels->data() + labels->size()),
              testing::ElementsAre(0, 1, 7, 15));
  EXPECT_EQ((*ReadRgb(folder / "l.png"))(3, 0, 0), 255);
}

TEST(ImageIoTest, TruncatedAndDamagedFilesDoNotCrash) {
  const TemporaryFolder folder;
  for (const char* suffix : {".png", ".jpg", ".tif"}) {
    const fs::path whole = folder / (std::string("whole") + suffix);
    const fs::path broken = folder / (std::string("broken") + suffix);
    ASSERT_TRUE(WriteImage(whole, Noise(40, 30, 3)).ok());
    const std::string bytes = *ReadFile(whole);
    for (size_t n = 0; n < bytes.size(); n += bytes.size() / 40 + 1) {
      WriteText(broken, bytes.substr(0, n));
      // A decoder may return what it got of a file cut near its end.
      const StatusOr<ImageU8> image = ReadRgb(broken);
      if (image.ok()) {
        EXPECT_EQ(image->width(), 40);
      }
    }
    for (uint64_t k = 0; k < 60; ++k) {
      std::string damaged = bytes;
      for (uint64_t i = 0; i < 4; ++i) {
        damaged[RandomIndex(
            k, 1, i, damaged.size() < 200 ? damaged.size() : 200)] =
            static_cast<char>(RandomBits(k, 2, i));
      }
      WriteText(broken, damaged);
      (void)ReadRgb(broken);
      (void)ReadLabels(broken);
    }
  }
}

TEST(ImageIoTest, WhatIsNoImageIsBadInput) {
  const TemporaryFolder folder;
  WriteText(folder / "text.jpg", "this is not a photo\n");
  WriteText(folder / "empty.jpg", "");
  for (const char* name : {"text.jpg", "empty.jpg", "missing.jpg"}) {
    EXPECT_EQ(ReadRgb(folder / name).status().code(), StatusCode::kBadInput);
    EXPECT_EQ(ReadLabels(folder / name).status().code(), StatusCode::kBadInput);
  }
}

TEST(ImageIoTest, HeaderThatClaimsAHugeImageIsRefused) {
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteImage(folder / "a.png", Noise(4, 4, 3)).ok());
  std::string bytes = *ReadFile(folder / "a.png");
  // Width and height of the IHDR chunk, big-endian, at bytes 16 and 20.
  bytes.replace(16, 8, std::string("\x7f\xff\xff\xff\x7f\xff\xff\xff", 8));
  WriteText(folder / "a.png", bytes);
  EXPECT_EQ(ReadRgb(folder / "a.png").status().code(), StatusCode::kBadInput);
}

TEST(ImageIoTest, FileThatClaimsMorePixelsThanItHoldsIsRefusedUnread) {
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteImage(folder / "a.png", Noise(4, 4, 3)).ok());
  std::string bytes = *ReadFile(folder / "a.png");
  bytes.replace(16, 8, std::string("\0\0\x7f\xff\0\0\x80\0", 8));
  WriteText(folder / "a.png", bytes);
  for (const Status& status : {ReadRgb(folder / "a.png").status(),
                               ReadLabels(folder / "a.png").status()}) {
    EXPECT_EQ(status.code(), StatusCode::kBadInput);
    EXPECT_THAT(status.message(),
                testing::HasSubstr("claims 32767 x 32768 pixels"));
  }
  ASSERT_TRUE(WriteImage(folder / "a.jpg", Noise(4, 4, 3)).ok());
  bytes = *ReadFile(folder / "a.jpg");
  const size_t frame = bytes.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  bytes.replace(frame + 5, 4, "\x7f\xff\x7f\xff");
  WriteText(folder / "a.jpg", bytes);
  EXPECT_THAT(ReadRgb(folder / "a.jpg").status().message(),
              testing::HasSubstr("claims 32767 x 32767 pixels"));
  ASSERT_TRUE(WriteImage(folder / "a.tif", Noise(4, 4, 3)).ok());
  bytes = *ReadFile(folder / "a.tif");
  // The directory's first entries: width and height, each one short number.
  const size_t width = bytes.find(std::string("\0\1\3\0\1\0\0\0\4\0", 10));
  ASSERT_NE(width, std::string::npos);
  for (const size_t entry : {width, width + 12}) {
    bytes.replace(entry + 2, 1, "\4");
    bytes.replace(entry + 8, 4, std::string("\xff\x7f\0\0", 4));
  }
  WriteText(folder / "a.tif", bytes);
  EXPECT_THAT(ReadRgb(folder / "a.tif").status().message(),
              testing::HasSubstr("claims 32767 x 32767 pixels"));
  bytes.replace(width + 2, 1, "\20");  // A number of 64 bits, stored elsewhere.
  WriteText(folder / "a.tif", bytes);
  EXPECT_THAT(ReadRgb(folder / "a.tif").status().message(),
              testing::HasSubstr("claims 2147483648 x 32767 pixels"));
  // One colour packs well.
  const ImageU16 plain(5000, 4000, 1);
  ASSERT_TRUE(WriteLabels(folder / "b.png", plain).ok());
  EXPECT_TRUE(ReadLabels(folder / "b.png").ok());
  ASSERT_TRUE(WriteImage(folder / "b.jpg", ImageU8(5000, 4000, 3)).ok());
  EXPECT_TRUE(ReadRgb(folder / "b.jpg").ok());
}

TEST(ImageIoTest, FormatsWhoseHeadersAreNotKnownAreRefused) {
  const TemporaryFolder folder;
  // A bitmap of 32767 x 32767 pixels without a pixel.
  WriteText(folder / "a.png",
            std::string("BM\x36\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0"
                        "\xff\x7f\0\0\xff\x7f\0\0\1\0\x18\0",
                        30) +
                std::string(24, '\0'));
  const Status status = ReadRgb(folder / "a.png").status();
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(),
              testing::HasSubstr("not a PNG, JPEG or TIFF image"));
}

TEST(ImageIoTest, AnImageWithoutPixelsIsNotWritten) {
  const TemporaryFolder folder;
  for (const int channels : {1, 3, 4}) {
    for (const auto& [width, height] : {std::pair(0, 5), std::pair(5, 0)}) {
      EXPECT_EQ(
          WriteImage(folder / "a.png", ImageU8(width, height, channels)).code(),
          StatusCode::kInternal);
    }
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "a.png"));
}

TEST(ImageIoTest, WriteErrors) {
  const TemporaryFolder folder;
  for (const char* name : {"a.xyz", "a.webp", "a.bmp", "a"}) {
    EXPECT_THAT(WriteImage(folder / name, Noise(4, 4, 3)).message(),
                testing::HasSubstr("ends with none of .png"))
        << name;
  }
  EXPECT_FALSE(WriteImage(folder / "a.png", Noise(4, 4, 2)).ok());
  EXPECT_FALSE(WriteImage(folder / "no" / "a.png", Noise(4, 4, 3)).ok());
}

TEST(ImageIoTest, FloatAndBack) {
  ImageU8 all(256, 1, 1);
  for (int i = 0; i < 256; ++i) all(i, 0) = static_cast<uint8_t>(i);
  EXPECT_TRUE(Same(ToU8(ToFloat(all)), all));
  ImageF odd(3, 1, 1);
  odd(0, 0) = -1.0f;
  odd(1, 0) = 2.0f;
  odd(2, 0) = 0.5f;
  const ImageU8 clamped = ToU8(odd);
  EXPECT_EQ(clamped(0, 0), 0);
  EXPECT_EQ(clamped(1, 0), 255);
  EXPECT_EQ(clamped(2, 0), 128);
}

TEST(ImageIoTest, ResizeKeepsTheMean) {
  const ImageU8 image = Noise(64, 48, 3);
  const auto mean = [](const ImageU8& i) {
    double sum = 0;
    for (size_t k = 0; k < i.size(); ++k) sum += i.data()[k];
    return sum / static_cast<double>(i.size());
  };
  const ImageU8 smaller = Resize(image, 16, 12);
  EXPECT_EQ(smaller.width(), 16);
  EXPECT_EQ(smaller.height(), 12);
  EXPECT_NEAR(mean(smaller), mean(image), 0.5);
  EXPECT_EQ(Resize(image, 100, 70).width(), 100);
  EXPECT_TRUE(Same(Resize(image, 64, 48), image));
}

TEST(ImageIoTest, SuffixesThatCanBeWritten) {
  EXPECT_TRUE(CanWriteImage("a.png"));
  EXPECT_TRUE(CanWriteImage("folder/a.JPG"));
  EXPECT_TRUE(CanWriteImage("a.jpeg"));
  EXPECT_TRUE(CanWriteImage("a.jpe"));
  EXPECT_TRUE(CanWriteImage("a.Tiff"));
  EXPECT_FALSE(CanWriteImage("a.webp"));
  EXPECT_FALSE(CanWriteImage("a.bmp"));
  EXPECT_FALSE(CanWriteImage("heat"));
  EXPECT_FALSE(CanWriteImage("heat.txt"));
  EXPECT_FALSE(CanWriteImage("folder.png/heat"));
}

}  // namespace
}  // namespace freegs
