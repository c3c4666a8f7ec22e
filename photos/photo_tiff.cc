// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_tiff.h"

#include <algorithm>

namespace freegs::photos {
namespace {

constexpr size_t kHeaderBytes = 8;
constexpr size_t kEntryBytes = 12;
constexpr uint32_t kMaxTextBytes = 256;  // More than any camera's name.

enum TiffType : uint16_t {
  kByte = 1,
  kAscii = 2,
  kShort = 3,
  kLong = 4,
  kRational = 5,
  kIfd = 13  // A directory's offset (TIFF Technical Note 1), as LONG.
};

// Bytes per value, 0 for types that hold nothing we read.
int ValueBytes(uint16_t type) {
  switch (type) {
    case kByte:
    case kAscii:
      return 1;
    case kShort:
      return 2;
    case kLong:
    case kIfd:
      return 4;
    case kRational:
      return 8;
    default:
      return 0;
  }
}

}  // namespace

StatusOr<TiffReader> TiffReader::Open(std::string_view bytes) {
  if (bytes.size() < kHeaderBytes) {
    return BadInputError("truncated TIFF header");
  }
  const std::string_view order = bytes.substr(0, 2);
  if (order != "II" && order != "MM") return BadInputError("not a TIFF header");
  TiffReader reader(bytes, order == "II");
  const uint32_t magic = reader.Load(2, 2);
  if (magic == 43) {
    return BadInputError(
        "BigTIFF is not supported; convert it to PNG or classic TIFF");
  }
  if (magic != 42) return BadInputError("not a TIFF header");
  reader.first_directory_ = reader.Load(4, 4);
  return reader;
}

StatusOr<std::vector<TiffEntry>> TiffReader::Directory(size_t offset,
                                                       bool* complete) const {
  if (offset < kHeaderBytes || offset > bytes_.size() ||
      bytes_.size() - offset < 2) {
    return BadInputError("truncated TIFF: its directory lies outside the file");
  }
  const size_t count = Load(offset, 2);
  const size_t first = offset + 2;
  if ((bytes_.size() - first) / kEntryBytes < count) {
    return BadInputError("truncated TIFF: its directory lies outside the file");
  }
  std::vector<TiffEntry> entries;
  for (size_t i = 0; i < count; ++i) {
    const size_t at = first + i * kEntryBytes;
    TiffEntry entry;
    entry.tag = static_cast<uint16_t>(Load(at, 2));
    entry.type = static_cast<uint16_t>(Load(at + 2, 2));
    entry.count = Load(at + 4, 4);
    const int value_bytes = ValueBytes(entry.type);
    if (value_bytes == 0 || entry.count == 0) continue;
    const uint64_t size = uint64_t{entry.count} * value_bytes;
    // Up to four bytes of values are stored in place of their offset.
    entry.offset = size <= 4 ? at + 8 : Load(at + 8, 4);
    if (entry.offset > bytes_.size() || bytes_.size() - entry.offset < size) {
      if (complete != nullptr) *complete = false;
      continue;
    }
    entries.push_back(entry);
  }
  return entries;
}

std::optional<uint32_t> TiffReader::Unsigned(const TiffEntry& entry,
                                             uint32_t index) const {
  if (index >= entry.count) return std::nullopt;
  if (entry.type == kAscii || entry.type == kRational) return std::nullopt;
  const int size = ValueBytes(entry.type);
  return Load(entry.offset + size_t{index} * size, size);
}

std::optional<double> TiffReader::Real(const TiffEntry& entry) const {
  if (entry.type == kRational) {
    const uint32_t denominator = Load(entry.offset + 4, 4);
    if (denominator == 0) return std::nullopt;
    return static_cast<double>(Load(entry.offset, 4)) / denominator;
  }
  const std::optional<uint32_t> value = Unsigned(entry);
  if (!value) return std::nullopt;
  return static_cast<double>(*value);
}

std::string TiffReader::Text(const TiffEntry& entry) const {
  if (entry.type != kAscii) return "";
  std::string_view text =
      bytes_.substr(entry.offset, std::min(entry.count, kMaxTextBytes));
  text = text.substr(0, text.find('\0'));
  const size_t first = text.find_first_not_of(' ');
  if (first == std::string_view::npos) return "";
  text = text.substr(first, text.find_last_not_of(' ') - first + 1);
  std::string printable(text);
  for (char& c : printable) {
    if (c < 0x20 || c > 0x7e) c = '?';
  }
  return printable;
}

uint32_t TiffReader::Load(size_t offset, int size) const {
  uint32_t value = 0;
  for (int i = 0; i < size; ++i) {
    const int from = little_endian_ ? size - 1 - i : i;
    value = value << 8 | static_cast<uint8_t>(bytes_[offset + from]);
  }
  return value;
}

const TiffEntry* FindTag(const std::vector<TiffEntry>& directory,
                         uint16_t tag) {
  const auto found = std::find_if(
      directory.begin(), directory.end(), [tag](const TiffEntry& e) {
        return e.tag == tag;
      });
  return found == directory.end() ? nullptr : &*found;
}

}  // namespace freegs::photos
