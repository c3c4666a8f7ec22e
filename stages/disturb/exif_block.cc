// SPDX-License-Identifier: BSD-3-Clause
// Sources: ITU-T T.81 annex B (segments of a JPEG); W3C PNG (Second Edition),
// section 5 (chunks); CIPA DC-008 (Exif 2.32), section 4.5 and tables 4 and 7.

#include "stages/disturb/exif_block.h"

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>
#include <zlib.h>

namespace freegs::stages {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view kJpegStart = "\xff\xd8"sv;
constexpr std::string_view kExifPrefix = "Exif\0\0"sv;
constexpr int kExifSegment = 0xe1;
constexpr int kStartOfImage = 0xd8;
constexpr int kEndOfImage = 0xd9;
constexpr int kStartOfScan = 0xda;
constexpr size_t kMaxSegment = 0xffff;

constexpr std::string_view kPngStart = "\x89PNG\r\n\x1a\n"sv;
constexpr size_t kChunkOverhead = 12;  // Length, type and checksum.
constexpr size_t kHeaderChunkEnd = 8 + kChunkOverhead + 13;

// A number of `size` bytes, the most significant first.
std::string BigEndian(uint64_t value, int size) {
  std::string bytes;
  for (int i = size - 1; i >= 0; --i) {
    bytes += static_cast<char>(value >> 8 * i & 0xff);
  }
  return bytes;
}

uint64_t Number(std::string_view bytes, size_t at, int size) {
  uint64_t value = 0;
  for (int i = 0; i < size; ++i) {
    value = value << 8 | static_cast<uint8_t>(bytes[at + i]);
  }
  return value;
}

// Where something lies in a file.
struct Place {
  size_t begin = 0;
  size_t end = 0;
  size_t content = 0;      // Where the EXIF block in it begins,
  size_t content_end = 0;  // and ends.
};

// The EXIF segment of a JPEG; it lies before the first scan. What is skipped
// between segments is what photos::ParseJpegHeader skips.
std::optional<Place> JpegExif(std::string_view file) {
  size_t at = kJpegStart.size();
  while (at + 4 <= file.size()) {
    const auto marker = static_cast<int>(Number(file, at + 1, 1));
    if (Number(file, at, 1) != 0xff || marker == 0xff) {
      ++at;  // Garbage, or bytes that fill.
      continue;
    }
    if (marker <= 1 || (marker >= 0xd0 && marker <= kStartOfImage)) {
      at += 2;  // Markers without a segment.
      continue;
    }
    if (marker == kEndOfImage || marker == kStartOfScan) break;
    const size_t length = Number(file, at + 2, 2);
    const size_t end = at + 2 + length;
    if (length < 2 || end > file.size()) break;
    if (marker == kExifSegment &&
        file.substr(at + 4, end - at - 4).starts_with(kExifPrefix)) {
      return Place{at, end, at + 4 + kExifPrefix.size(), end};
    }
    at = end;
  }
  return std::nullopt;
}

// The eXIf chunk of a PNG.
std::optional<Place> PngExif(std::string_view file) {
  size_t at = kPngStart.size();
  while (at + kChunkOverhead <= file.size()) {
    const size_t end = at + kChunkOverhead + Number(file, at, 4);
    if (end > file.size()) break;
    if (file.substr(at + 4, 4) == "eXIf") {
      return Place{at, end, at + 8, end - 4};
    }
    at = end;
  }
  return std::nullopt;
}

std::string JpegSegment(std::string_view block) {
  std::string segment = "\xff\xe1";
  segment += BigEndian(2 + kExifPrefix.size() + block.size(), 2);
  segment += kExifPrefix;
  segment += block;
  return segment;
}

std::string PngChunk(std::string_view block) {
  std::string data = "eXIf";
  data += block;
  const uLong sum = crc32(0,
                          reinterpret_cast<const Bytef*>(data.data()),
                          static_cast<uInt>(data.size()));
  std::string chunk = BigEndian(block.size(), 4);
  chunk += data;
  chunk += BigEndian(sum, 4);
  return chunk;
}

// One tag of a directory; its value has the type's size times the count.
struct Tag {
  uint16_t tag;
  uint16_t type;
  uint32_t count;
  std::string value;
};

constexpr uint16_t kAscii = 2;
constexpr uint16_t kShort = 3;
constexpr uint16_t kLong = 4;
constexpr uint16_t kRational = 5;

Tag ShortTag(uint16_t tag, int value) {
  return {tag, kShort, 1, BigEndian(static_cast<uint64_t>(value), 2)};
}

Tag LongTag(uint16_t tag, uint64_t value) {
  return {tag, kLong, 1, BigEndian(value, 4)};
}

Tag TextTag(uint16_t tag, const std::string& text) {
  return {tag,
          kAscii,
          static_cast<uint32_t>(text.size() + 1),
          text + std::string(1, '\0')};
}

// Values are rounded to a ten-thousandth.
Tag RationalTag(uint16_t tag, double value) {
  constexpr int kDenominator = 10000;
  return {tag,
          kRational,
          1,
          BigEndian(std::llround(value * kDenominator), 4) +
              BigEndian(kDenominator, 4)};
}

// A directory that begins at byte `start`, with what its tags point to.
std::string Directory(const std::vector<Tag>& tags, size_t start) {
  std::string entries = BigEndian(tags.size(), 2);
  std::string values;
  const size_t values_at = start + 2 + 12 * tags.size() + 4;
  for (const Tag& tag : tags) {
    entries += BigEndian(tag.tag, 2) + BigEndian(tag.type, 2) +
               BigEndian(tag.count, 4);
    if (tag.value.size() <= 4) {
      entries += tag.value + std::string(4 - tag.value.size(), '\0');
    } else {
      entries += BigEndian(values_at + values.size(), 4);
      values += tag.value;
      if (values.size() % 2 != 0) values += '\0';
    }
  }
  return entries + BigEndian(0, 4) + values;
}

}  // namespace

std::string ExifBlockOf(std::string_view file) {
  std::optional<Place> place;
  if (file.starts_with(kJpegStart)) place = JpegExif(file);
  if (file.starts_with(kPngStart)) place = PngExif(file);
  if (!place) return "";
  return std::string(
      file.substr(place->content, place->content_end - place->content));
}

StatusOr<std::string> WithExifBlock(std::string_view file,
                                    std::string_view block) {
  const bool jpeg = file.starts_with(kJpegStart);
  if (!jpeg &&
      (!file.starts_with(kPngStart) || file.size() < kHeaderChunkEnd)) {
    return BadInputError("neither a JPEG nor a PNG");
  }
  if (jpeg && block.size() + kExifPrefix.size() + 2 > kMaxSegment) {
    return BadInputError("its EXIF block is too large for a JPEG");
  }
  std::string result(file);
  if (const auto old = jpeg ? JpegExif(file) : PngExif(file)) {
    result.erase(old->begin, old->end - old->begin);
  }
  if (block.empty()) return result;
  // EXIF is the first segment of a JPEG. In a PNG the header comes first.
  if (jpeg) return result.insert(kJpegStart.size(), JpegSegment(block));
  return result.insert(kHeaderChunkEnd, PngChunk(block));
}

std::string ExifBlockWithFocal(const photos::ExifTags& tags, double focal) {
  // A sensor of 36 mm, and a picture of 3600 pixels on it: what is read is the
  // focal length by the longest side, whatever the size of the picture.
  constexpr int kPixels = 3600;
  constexpr int kMillimetres = 36;
  constexpr int kCentimetres = 3;  // The unit of the sensor's resolution.
  std::vector<Tag> first;
  if (!tags.make.empty()) first.push_back(TextTag(0x010f, tags.make));
  if (!tags.model.empty()) first.push_back(TextTag(0x0110, tags.model));
  first.push_back(ShortTag(0x0112, tags.orientation));
  first.push_back(LongTag(0x8769, 0));  // Where the second directory begins.
  constexpr size_t kStart = 8;
  const size_t second_at = kStart + Directory(first, kStart).size();
  first.back() = LongTag(0x8769, second_at);
  const std::vector<Tag> second = {RationalTag(0x920a, focal * kMillimetres),
                                   LongTag(0xa002, kPixels),
                                   LongTag(0xa003, kPixels),
                                   RationalTag(0xa20e, 1000),
                                   ShortTag(0xa210, kCentimetres)};
  std::string block = "MM";
  block += BigEndian(42, 2);
  block += BigEndian(kStart, 4);
  block += Directory(first, kStart);
  block += Directory(second, second_at);
  return block;
}

}  // namespace freegs::stages
