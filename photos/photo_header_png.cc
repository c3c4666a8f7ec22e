// SPDX-License-Identifier: BSD-3-Clause
// PNG: W3C Portable Network Graphics (Second Edition), sections 5 and 11.

#include <algorithm>
#include <array>
#include <optional>

#include "photos/photo_header.h"

namespace freegs::photos {
namespace {

constexpr size_t kSignatureBytes = 8;
constexpr size_t kChunkOverhead = 12;  // Length, type and checksum.
// The best that Deflate can do.
constexpr double kMaxCompression = 1032;
// The value of chunk gAMA for sRGB, which viewers show as it is stored.
constexpr uint32_t kSrgbGamma = 45455;

enum ColourType {
  kGrey = 0,
  kRgb = 2,
  kPalette = 3,
  kGreyAlpha = 4,
  kRgba = 6
};

constexpr std::array<uint32_t, 256> MakeCrcTable() {
  std::array<uint32_t, 256> table = {};
  for (uint32_t i = 0; i < 256; ++i) {
    uint32_t crc = i;
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc & 1) != 0 ? 0xedb88320U ^ (crc >> 1) : crc >> 1;
    }
    table[i] = crc;
  }
  return table;
}
constexpr std::array<uint32_t, 256> kCrcTable = MakeCrcTable();

uint32_t Crc(std::string_view bytes) {
  uint32_t crc = 0xffffffffU;
  for (const char c : bytes) {
    crc = kCrcTable[(crc ^ static_cast<uint8_t>(c)) & 0xff] ^ (crc >> 8);
  }
  return ~crc;
}

uint32_t Long(std::string_view bytes, size_t at) {
  uint32_t value = 0;
  for (size_t i = 0; i < 4; ++i) {
    value = value << 8 | static_cast<uint8_t>(bytes[at + i]);
  }
  return value;
}

struct Chunk {
  std::string_view whole;  // With length and checksum.
  std::string_view type;
  std::string_view data;

  bool essential() const {
    return type == "IHDR" || type == "PLTE" || type == "tRNS" ||
           type == "IDAT" || type == "IEND";
  }

  // Whether a program that does not know the chunk may skip it: its name is of
  // letters, and the first one is small (section 5.4).
  bool ancillary() const {
    const auto is_letter = [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    };
    return std::all_of(type.begin(), type.end(), is_letter) && type[0] >= 'a';
  }
};

// The chunk at `at`, or nothing if it does not lie in the file as a whole.
std::optional<Chunk> ChunkAt(std::string_view bytes, size_t at) {
  if (at > bytes.size() || bytes.size() - at < kChunkOverhead) {
    return std::nullopt;
  }
  const size_t length = Long(bytes, at);
  if (bytes.size() - at - kChunkOverhead < length) return std::nullopt;
  return Chunk{bytes.substr(at, length + kChunkOverhead),
               bytes.substr(at + 4, 4),
               bytes.substr(at + 8, length)};
}

bool IsValidDepth(int bits, int colour) {
  switch (colour) {
    case kGrey:
      return bits == 1 || bits == 2 || bits == 4 || bits == 8 || bits == 16;
    case kPalette:
      return bits == 1 || bits == 2 || bits == 4 || bits == 8;
    case kRgb:
    case kGreyAlpha:
    case kRgba:
      return bits == 8 || bits == 16;
    default:
      return false;
  }
}

Status ReadHeaderChunk(std::string_view data, PhotoHeader* header) {
  Status damaged = BadInputError("damaged PNG header; copy the file again");
  if (data.size() != 13) return damaged;
  header->width = Long(data, 0);
  header->height = Long(data, 4);
  header->bits = static_cast<uint8_t>(data[8]);
  const int colour = static_cast<uint8_t>(data[9]);
  if (header->width == 0 || header->height == 0 ||
      !IsValidDepth(header->bits, colour) || data[10] != 0 || data[11] != 0 ||
      static_cast<uint8_t>(data[12]) > 1) {
    return damaged;
  }
  const bool grey = colour == kGrey || colour == kGreyAlpha;
  header->has_alpha = colour == kGreyAlpha || colour == kRgba;
  header->samples = (grey ? 1 : 3) + (header->has_alpha ? 1 : 0);
  if (colour == kPalette) header->samples = 1;
  header->plain = colour != kPalette && header->bits >= 8;
  return Status();
}

// The sample that is transparent, as the decoder stretches it: samples of less
// than 8 bits become 0..255.
int TransparentGrey(std::string_view data, int bits) {
  const int full = (1 << bits) - 1;
  const int grey =
      (static_cast<uint8_t>(data[0]) << 8 | static_cast<uint8_t>(data[1])) &
      full;
  return bits < 8 ? grey * 255 / full : grey;
}

// OpenCV ignores the chunk gAMA. FreeImage, with which COLMAP reads, applies
// any gamma that differs from that of sRGB. No program that is used here
// changes pixels because of sRGB, iCCP or cHRM.
bool ChangesBrightness(const Chunk& chunk) {
  return chunk.type == "gAMA" &&
         (chunk.data.size() != 4 || Long(chunk.data, 0) != kSrgbGamma);
}

}  // namespace

StatusOr<PhotoHeader> ParsePngHeader(std::string_view bytes) {
  PhotoHeader header;
  header.format = PhotoFormat::kPng;
  header.truncated = true;  // Until the last chunk is found.
  double data_bytes = 0;
  std::string_view previous_type;
  int data_runs = 0;  // IDAT chunks with nothing between them are one.
  size_t at = kSignatureBytes;
  while (const std::optional<Chunk> chunk = ChunkAt(bytes, at)) {
    const bool first = at == kSignatureBytes;
    if (first != (chunk->type == "IHDR")) {
      return BadInputError("damaged PNG header; copy the file again");
    }
    if (chunk->essential() &&
        Crc(chunk->whole.substr(4, chunk->whole.size() - 8)) !=
            Long(chunk->whole, chunk->whole.size() - 4)) {
      return BadInputError("damaged PNG: a checksum of its " +
                           std::string(chunk->type) +
                           " data is wrong; copy the file again");
    }
    if (first) {
      FREEGS_RETURN_IF_ERROR(ReadHeaderChunk(chunk->data, &header));
    } else if (chunk->type == "tRNS") {
      header.has_alpha = true;
      header.plain = false;
      if (chunk->data.size() == 2) {
        header.transparent_grey = TransparentGrey(chunk->data, header.bits);
      }
    } else if (chunk->type == "eXIf") {
      header.exif = ParseExif(chunk->data);
    } else if (chunk->type == "IDAT") {
      data_bytes += static_cast<double>(chunk->data.size());
      if (previous_type != "IDAT") ++data_runs;
    } else if (chunk->type == "IEND") {
      header.truncated = false;
      break;
    }
    if (ChangesBrightness(*chunk)) header.plain = false;
    // Decoders refuse a file with such a chunk, even if its picture is sound.
    if (!chunk->essential() && !chunk->ancillary()) header.plain = false;
    previous_type = chunk->type;
    at += chunk->whole.size();
  }
  // Decoders want these chunks one after the other.
  if (data_runs > 1) header.plain = false;
  if (header.width == 0) {
    return BadInputError(
        "truncated PNG: it ends within its header; copy the file again");
  }
  header.max_pixels =
      kMaxCompression * data_bytes * 8 / (header.bits * header.samples);
  return header;
}

std::string EssentialPng(std::string_view bytes) {
  std::string essential(bytes.substr(0, kSignatureBytes));
  essential.reserve(bytes.size());
  size_t at = kSignatureBytes;
  while (const std::optional<Chunk> chunk = ChunkAt(bytes, at)) {
    if (chunk->essential()) essential += chunk->whole;
    if (chunk->type == "IEND") break;
    at += chunk->whole.size();
  }
  return essential;
}

}  // namespace freegs::photos
