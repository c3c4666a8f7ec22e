// SPDX-License-Identifier: BSD-3-Clause
// JPEG: ITU-T T.81 annex B, the order and length of marker segments.

#include <cstring>

#include "photos/photo_header.h"

namespace freegs::photos {
namespace {

using namespace std::string_view_literals;

constexpr int kStartOfImage = 0xd8;
constexpr int kEndOfImage = 0xd9;
constexpr int kStartOfScan = 0xda;
constexpr int kExifSegment = 0xe1;
constexpr std::string_view kExifPrefix = "Exif\0\0"sv;

// A Huffman coded picture spends at least one bit on each 8x8 block of its
// first scan.
constexpr double kMaxPixelsPerByte = 64 * 8;
// Arithmetic coding can spend less; this only bounds the absurd.
constexpr double kMaxPixelsPerByteArithmetic = 64 * 8 * 64;

int Byte(std::string_view bytes, size_t at) {
  return static_cast<uint8_t>(bytes[at]);
}

int Short(std::string_view bytes, size_t at) {
  return Byte(bytes, at) << 8 | Byte(bytes, at + 1);
}

bool StandsAlone(int marker) {
  return marker == 0x01 || (marker >= 0xd0 && marker <= kStartOfImage);
}

bool IsFrame(int marker) {
  return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 &&
         marker != 0xcc;
}

// The position of the next marker (its 0xff) that ends entropy coded data, or
// the end of the bytes.
size_t SkipEntropyCoded(std::string_view bytes, size_t at) {
  while (at + 1 < bytes.size()) {
    const void* found =
        std::memchr(bytes.data() + at, 0xff, bytes.size() - 1 - at);
    if (found == nullptr) break;
    at = static_cast<const char*>(found) - bytes.data();
    const int next = Byte(bytes, at + 1);
    const bool restart = next >= 0xd0 && next <= 0xd7;
    if (next == 0xff) {
      ++at;  // A fill byte.
    } else if (next == 0 || restart) {
      at += 2;
    } else {
      return at;
    }
  }
  return bytes.size();
}

Status ReadFrame(std::string_view segment, int marker, PhotoHeader* header) {
  if (segment.size() < 6) return BadInputError("damaged JPEG header");
  header->bits = Byte(segment, 0);
  header->height = Short(segment, 1);
  header->width = Short(segment, 3);
  header->samples = Byte(segment, 5);
  if (header->bits != 8) {
    return BadInputError("a JPEG of " + std::to_string(header->bits) +
                         " bits per sample; convert it to PNG or 8 bits");
  }
  if (header->height == 0 || header->width == 0) {
    return BadInputError("the JPEG header gives no size; convert it to PNG");
  }
  if (header->samples != 1 && header->samples != 3 && header->samples != 4) {
    return BadInputError("a JPEG of " + std::to_string(header->samples) +
                         " colour components; convert it to RGB");
  }
  header->plain = header->samples != 4;
  header->max_pixels =
      marker >= 0xc9 ? kMaxPixelsPerByteArithmetic : kMaxPixelsPerByte;
  return Status();
}

}  // namespace

StatusOr<PhotoHeader> ParseJpegHeader(std::string_view bytes) {
  PhotoHeader header;
  header.format = PhotoFormat::kJpeg;
  header.truncated = true;  // Until the end of the image is found.
  bool has_exif = false;
  size_t at = 2;
  while (at + 1 < bytes.size()) {
    if (Byte(bytes, at) != 0xff) {
      ++at;  // Decoders skip garbage between segments.
      continue;
    }
    const int marker = Byte(bytes, at + 1);
    if (marker == 0xff) {
      ++at;
      continue;
    }
    at += 2;
    if (marker == kEndOfImage) {
      header.truncated = false;
      break;
    }
    if (marker == 0 || StandsAlone(marker)) continue;
    if (bytes.size() - at < 2) break;
    const size_t length = Short(bytes, at);
    if (length < 2) return BadInputError("damaged JPEG header");
    if (bytes.size() - at < length) break;
    const std::string_view segment = bytes.substr(at + 2, length - 2);
    if (IsFrame(marker)) {
      // Decoders take the first one, and the limits must hold for that one.
      if (header.width != 0) {
        return BadInputError(
            "damaged JPEG: it has two frame headers; copy the file again");
      }
      FREEGS_RETURN_IF_ERROR(ReadFrame(segment, marker, &header));
    } else if (marker == kExifSegment && !has_exif &&
               segment.starts_with(kExifPrefix)) {
      has_exif = true;
      header.exif = ParseExif(segment.substr(kExifPrefix.size()));
    }
    at += length;
    if (marker == kStartOfScan) at = SkipEntropyCoded(bytes, at);
  }
  if (header.width == 0) {
    return BadInputError(
        header.truncated
            ? "truncated JPEG: it ends within its header; copy the file again"
            : "a JPEG without a picture; copy the file again");
  }
  header.max_pixels *= static_cast<double>(bytes.size());
  return header;
}

}  // namespace freegs::photos
