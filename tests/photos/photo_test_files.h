// SPDX-License-Identifier: BSD-3-Clause
// Photo files for tests: good ones, and ones with a chosen fault.

#ifndef FREEGS_TESTS_PHOTOS_PHOTO_TEST_FILES_H_
#define FREEGS_TESTS_PHOTOS_PHOTO_TEST_FILES_H_

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/image.h"
#include "core/random.h"
#include "tests/temporary_folder.h"

namespace freegs::photos {

// A smooth random picture, BGR, different for each seed: as compressible as a
// photo, and unlike any turned or mirrored copy of itself.
inline cv::Mat MakePicture(int width, int height, uint64_t seed) {
  cv::Mat coarse(8, 8, CV_8UC3);
  for (int i = 0; i < 8 * 8 * 3; ++i) {
    coarse.data[i] = static_cast<uint8_t>(RandomIndex(seed, 7, i, 256));
  }
  cv::Mat picture;
  cv::resize(coarse, picture, {width, height}, 0, 0, cv::INTER_CUBIC);
  return picture;
}

inline std::string Encode(const std::string& suffix,
                          const cv::Mat& picture,
                          const std::vector<int>& parameters = {}) {
  std::vector<uint8_t> bytes;
  EXPECT_TRUE(cv::imencode(suffix, picture, bytes, parameters));
  return std::string(bytes.begin(), bytes.end());
}

inline std::string MakeJpeg(int width, int height, uint64_t seed) {
  return Encode(".jpg", MakePicture(width, height, seed));
}

inline std::string MakePng(int width, int height, uint64_t seed) {
  return Encode(".png", MakePicture(width, height, seed));
}

// Integers of a given byte order.
inline std::string Bytes(uint64_t value, int size, bool little_endian = false) {
  std::string bytes;
  for (int i = 0; i < size; ++i) {
    const int shift = 8 * (little_endian ? i : size - 1 - i);
    bytes += static_cast<char>(value >> shift & 0xff);
  }
  return bytes;
}

// What MakeExif writes; 0 and "" leave a tag out.
struct ExifFields {
  int orientation = 0;
  std::string make = {};
  std::string model = {};
  int focal_mm_tenths = 0;
  int zoom_tenths = 0;  // Digital zoom.
  int focal_35mm = 0;
  int focal_plane_per_cm = 0;
  int pixel_width = 0;
  int pixel_height = 0;
  bool gps = false;  // 48 degrees north, 11 east.
};

// An EXIF block (TIFF structure) with these tags.
inline std::string MakeExif(const ExifFields& fields, bool little = true) {
  struct Tag {
    uint16_t tag;
    uint16_t type;
    uint32_t count;
    std::string value;
  };
  const auto number = [little](uint64_t value, int size) {
    return Bytes(value, size, little);
  };
  const auto text = [](uint16_t tag, const std::string& value) {
    return Tag{tag,
               2,
               static_cast<uint32_t>(value.size() + 1),
               value + std::string(1, '\0')};
  };
  std::vector<Tag> main;
  std::vector<Tag> exif;
  if (!fields.make.empty()) main.push_back(text(0x010f, fields.make));
  if (!fields.model.empty()) main.push_back(text(0x0110, fields.model));
  if (fields.orientation != 0) {
    main.push_back({0x0112, 3, 1, number(fields.orientation, 2)});
  }
  if (fields.focal_mm_tenths != 0) {
    exif.push_back(
        {0x920a, 5, 1, number(fields.focal_mm_tenths, 4) + number(10, 4)});
  }
  if (fields.pixel_width != 0) {
    exif.push_back({0xa002, 4, 1, number(fields.pixel_width, 4)});
    exif.push_back({0xa003, 4, 1, number(fields.pixel_height, 4)});
  }
  if (fields.focal_plane_per_cm != 0) {
    exif.push_back(
        {0xa20e, 5, 1, number(fields.focal_plane_per_cm, 4) + number(1, 4)});
    exif.push_back({0xa210, 3, 1, number(3, 2)});
  }
  if (fields.zoom_tenths != 0) {
    exif.push_back(
        {0xa404, 5, 1, number(fields.zoom_tenths, 4) + number(10, 4)});
  }
  if (fields.focal_35mm != 0) {
    exif.push_back({0xa405, 3, 1, number(fields.focal_35mm, 2)});
  }

  const auto directory = [&number](const std::vector<Tag>& tags, size_t start) {
    std::string entries = number(tags.size(), 2);
    std::string values;
    const size_t values_at = start + 2 + 12 * tags.size() + 4;
    for (const Tag& tag : tags) {
      entries +=
          number(tag.tag, 2) + number(tag.type, 2) + number(tag.count, 4);
      if (tag.value.size() <= 4) {
        entries += tag.value + std::string(4 - tag.value.size(), '\0');
      } else {
        entries += number(values_at + values.size(), 4);
        values += tag.value;
      }
    }
    return entries + number(0, 4) + values;
  };
  std::string block = little ? "II" : "MM";
  block += number(42, 2) + number(8, 4);
  // The pointer's value depends on the size of the directory that holds it.
  main.push_back({0x8769, 4, 1, number(0, 4)});
  if (fields.gps) main.push_back({0x8825, 4, 1, number(0, 4)});
  const size_t exif_at = 8 + directory(main, 8).size();
  const size_t gps_at = exif_at + directory(exif, exif_at).size();
  main[main.size() - (fields.gps ? 2 : 1)].value = number(exif_at, 4);
  if (fields.gps) main.back().value = number(gps_at, 4);
  block += directory(main, 8) + directory(exif, exif_at);
  if (!fields.gps) return block;
  const auto degrees = [&number](int value) {
    return number(value, 4) + number(1, 4) + number(0, 4) + number(1, 4) +
           number(0, 4) + number(1, 4);
  };
  return block + directory({{1, 2, 2, std::string("N\0", 2)},
                            {2, 5, 3, degrees(48)},
                            {3, 2, 2, std::string("E\0", 2)},
                            {4, 5, 3, degrees(11)}},
                           gps_at);
}

// The JPEG with an EXIF segment after its first marker.
inline std::string WithExif(const std::string& jpeg, const std::string& exif) {
  const std::string prefix("Exif\0\0", 6);
  return jpeg.substr(0, 2) + "\xff\xe1" +
         Bytes(prefix.size() + exif.size() + 2, 2) + prefix + exif +
         jpeg.substr(2);
}

// The JPEG with another size in its frame header.
inline std::string WithJpegSize(std::string jpeg, int width, int height) {
  const size_t frame = jpeg.find("\xff\xc0");
  EXPECT_NE(frame, std::string::npos);
  jpeg.replace(frame + 5, 4, Bytes(height, 2) + Bytes(width, 2));
  return jpeg;
}

// The JPEG with a second frame header, for another size, before its end: a
// decoder has taken memory for the first one when it gets there.
inline std::string WithSecondJpegFrame(const std::string& jpeg,
                                       int width,
                                       int height) {
  const std::string other = WithJpegSize(jpeg, width, height);
  const size_t frame = other.find("\xff\xc0");
  const size_t length = 2 + (static_cast<uint8_t>(other[frame + 2]) << 8 |
                             static_cast<uint8_t>(other[frame + 3]));
  return jpeg.substr(0, jpeg.size() - 2) + other.substr(frame, length) +
         jpeg.substr(jpeg.size() - 2);
}

// The little-endian TIFF with one more tag of type SHORT, in a new copy of its
// first directory at the end.
inline std::string WithTiffTag(std::string tiff, int tag, int value) {
  const auto number = [&tiff](size_t at, int size) {
    size_t result = 0;
    for (int i = 0; i < size; ++i) {
      result |= static_cast<size_t>(static_cast<uint8_t>(tiff[at + i]))
                << 8 * i;
    }
    return result;
  };
  const size_t first = number(4, 4);
  const size_t count = number(first, 2);
  std::string entries;
  bool written = false;
  const std::string entry = Bytes(tag, 2, true) + Bytes(3, 2, true) +
                            Bytes(1, 4, true) + Bytes(value, 4, true);
  for (size_t i = 0; i < count; ++i) {
    const size_t at = first + 2 + 12 * i;
    const int present = static_cast<int>(number(at, 2));
    if (!written && present >= tag) entries += entry;
    written = written || present >= tag;
    if (present != tag) entries += tiff.substr(at, 12);
  }
  if (!written) entries += entry;
  tiff.resize(tiff.size() + tiff.size() % 2, '\0');
  tiff.replace(4, 4, Bytes(tiff.size(), 4, true));
  return tiff + Bytes(entries.size() / 12, 2, true) + entries +
         Bytes(0, 4, true);
}

// What RawTiff writes; -1 leaves the tag out.
struct RawTiffFields {
  int bits = 8;  // Per sample: 8, 16, or less if there is one sample.
  int photometric = 1;
  int planar = 1;
  int extra = -1;  // What the last sample is.
};

// A little-endian TIFF of one colour, 40 x 40 pixels, without compression.
inline std::string RawTiff(const RawTiffFields& fields,
                           const std::vector<int>& pixel) {
  constexpr int kSide = 40;
  const size_t planes = fields.planar == 2 ? pixel.size() : 1;
  std::string bytes = "II" + Bytes(42, 2, true) + Bytes(0, 4, true);
  std::string offsets;
  std::string sizes;
  for (size_t plane = 0; plane < planes; ++plane) {
    const size_t first = bytes.size();
    offsets += Bytes(first, 4, true);
    if (fields.bits < 8) {
      int packed = 0;
      for (int bit = 0; bit < 8; bit += fields.bits) {
        packed |= pixel[0] << bit;
      }
      bytes += std::string(kSide * kSide * fields.bits / 8,
                           static_cast<char>(packed));
    }
    for (int i = 0; fields.bits >= 8 && i < kSide * kSide; ++i) {
      for (size_t k = 0; k < pixel.size(); ++k) {
        if (planes > 1 && k != plane) continue;
        bytes += Bytes(pixel[k], fields.bits / 8, true);
      }
    }
    sizes += Bytes(bytes.size() - first, 4, true);
  }
  std::string depths;
  for (size_t k = 0; k < pixel.size(); ++k) {
    depths += Bytes(fields.bits, 2, true);
  }
  const auto one = [](int value) { return Bytes(value, 2, true); };
  constexpr int kShort = 3;
  constexpr int kLong = 4;
  struct Tag {
    int tag;
    int type;
    std::string values;
  };
  std::vector<Tag> tags = {
      {256, kShort, one(kSide)},
      {257, kShort, one(kSide)},
      {258, kShort, depths},
      {259, kShort, one(1)},
      {262, kShort, one(fields.photometric)},
      {273, kLong, offsets},
      {277, kShort, one(static_cast<int>(pixel.size()))},
      {278, kShort, one(kSide)},
      {279, kLong, sizes},
      {284, kShort, one(fields.planar)},
  };
  if (fields.extra >= 0) tags.push_back({338, kShort, one(fields.extra)});
  std::string directory = Bytes(tags.size(), 2, true);
  for (Tag& tag : tags) {
    directory +=
        Bytes(tag.tag, 2, true) + Bytes(tag.type, 2, true) +
        Bytes(tag.values.size() / (tag.type == kShort ? 2 : 4), 4, true);
    if (tag.values.size() > 4) {
      directory += Bytes(bytes.size(), 4, true);
      bytes += tag.values + std::string(tag.values.size() % 2, '\0');
    } else {
      tag.values.resize(4);
      directory += tag.values;
    }
  }
  bytes.replace(4, 4, Bytes(bytes.size(), 4, true));
  return bytes + directory + Bytes(0, 4, true);
}

// The TIFF with another size in its header.
inline std::string WithTiffSize(const std::string& tiff,
                                int width,
                                int height) {
  return WithTiffTag(WithTiffTag(tiff, 256, width), 257, height);
}

inline uint32_t PngCrc(std::string_view bytes) {
  uint32_t crc = 0xffffffffU;
  for (const char c : bytes) {
    crc ^= static_cast<uint8_t>(c);
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc & 1) != 0 ? 0xedb88320U ^ (crc >> 1) : crc >> 1;
    }
  }
  return ~crc;
}

inline std::string PngChunk(const std::string& type, const std::string& data) {
  return Bytes(data.size(), 4) + type + data + Bytes(PngCrc(type + data), 4);
}

inline constexpr size_t kPngHeaderEnd = 8 + 25;  // Signature and IHDR.

// The PNG with another size in its header, and a checksum that fits.
inline std::string WithPngSize(const std::string& png,
                               uint32_t width,
                               uint32_t height) {
  const std::string data =
      Bytes(width, 4) + Bytes(height, 4) + png.substr(24, 5);
  return png.substr(0, 8) + PngChunk("IHDR", data) + png.substr(kPngHeaderEnd);
}

// A PNG of any colour type and depth from its raw rows (each with its filter
// byte), stored without compression; `chunks` go before the data.
inline std::string RawPng(int width,
                          int height,
                          int bits,
                          int colour,
                          const std::string& rows,
                          const std::string& chunks = "") {
  uint32_t a = 1;
  uint32_t b = 0;
  for (const char c : rows) {
    a = (a + static_cast<uint8_t>(c)) % 65521;
    b = (b + a) % 65521;
  }
  // One stored block: fine for up to 65535 bytes.
  const std::string data =
      std::string("\x78\x01\x01", 3) + Bytes(rows.size(), 2, true) +
      Bytes(~rows.size(), 2, true) + rows + Bytes(b << 16 | a, 4);
  const std::string header = Bytes(width, 4) + Bytes(height, 4) +
                             Bytes(bits, 1) + Bytes(colour, 1) +
                             std::string(3, '\0');
  return "\x89PNG\r\n\x1a\n" + PngChunk("IHDR", header) + chunks +
         PngChunk("IDAT", data) + PngChunk("IEND", "");
}

// The PNG with one more chunk after its header.
inline std::string WithPngChunk(const std::string& png,
                                const std::string& type,
                                const std::string& data) {
  return png.substr(0, kPngHeaderEnd) + PngChunk(type, data) +
         png.substr(kPngHeaderEnd);
}

// The PNG of OpenCV, which has one IDAT chunk, with two halves of that chunk
// and `between` between them.
inline std::string WithPngDataInTwo(const std::string& png,
                                    const std::string& between) {
  const size_t at = png.find("IDAT") - 4;
  const size_t end = png.size() - PngChunk("IEND", "").size();
  const std::string data = png.substr(at + 8, end - at - 12);
  const size_t half = data.size() / 2;
  return png.substr(0, at) + PngChunk("IDAT", data.substr(0, half)) + between +
         PngChunk("IDAT", data.substr(half)) + png.substr(end);
}

inline ImageU8 RgbOf(const cv::Mat& bgr) {
  ImageU8 image(bgr.cols, bgr.rows, 3);
  cv::Mat target(bgr.rows, bgr.cols, CV_8UC3, image.data());
  cv::cvtColor(bgr, target, cv::COLOR_BGR2RGB);
  return image;
}

// The largest difference of two numbers; 1000 for other sizes.
inline int LargestDifference(const ImageU8& a, const ImageU8& b) {
  if (a.width() != b.width() || a.height() != b.height()) return 1000;
  int largest = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, std::abs(a.data()[i] - b.data()[i]));
  }
  return largest;
}

}  // namespace freegs::photos

#endif  // FREEGS_TESTS_PHOTOS_PHOTO_TEST_FILES_H_
