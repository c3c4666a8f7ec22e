// SPDX-License-Identifier: BSD-3-Clause
// The directory structure of TIFF files, which EXIF blocks share. Reads tags
// only, never pixels, and trusts no offset or count of the file.

#ifndef FREEGS_PHOTOS_PHOTO_TIFF_H_
#define FREEGS_PHOTOS_PHOTO_TIFF_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"

namespace freegs::photos {

// One tag of a directory. All its values lie inside the file.
struct TiffEntry {
  uint16_t tag = 0;
  uint16_t type = 0;
  uint32_t count = 0;
  size_t offset = 0;  // Of the first value, from the start of the bytes.
};

// A view of bytes that outlive it. Source: TIFF Revision 6.0 (Adobe, 1992),
// section 2.
class TiffReader {
 public:
  // kBadInput when the bytes do not start with a classic TIFF header. BigTIFF
  // (offsets of 64 bits) is refused with advice.
  static StatusOr<TiffReader> Open(std::string_view bytes);

  size_t first_directory() const { return first_directory_; }
  bool little_endian() const { return little_endian_; }

  // The tags of the directory at `offset`. Tags of unknown type, or whose
  // values lie outside the file, are left out; the latter set `complete` to
  // false. kBadInput when the directory itself does not lie inside the file.
  StatusOr<std::vector<TiffEntry>> Directory(size_t offset,
                                             bool* complete = nullptr) const;

  // Value `index` of an entry of type BYTE, SHORT or LONG; nothing otherwise.
  std::optional<uint32_t> Unsigned(const TiffEntry& entry,
                                   uint32_t index = 0) const;

  // First value of a RATIONAL, or of an unsigned type; nothing when the
  // denominator is 0.
  std::optional<double> Real(const TiffEntry& entry) const;

  // An ASCII value up to its first NUL, without surrounding spaces; bytes
  // outside printable ASCII become '?'. Empty for other types.
  std::string Text(const TiffEntry& entry) const;

 private:
  TiffReader(std::string_view bytes, bool little_endian)
      : bytes_(bytes), little_endian_(little_endian) {}

  // Unsigned integer of `size` bytes; the caller has checked the range.
  uint32_t Load(size_t offset, int size) const;

  std::string_view bytes_;
  bool little_endian_ = true;
  size_t first_directory_ = 0;
};

// The entry of a tag, or null.
const TiffEntry* FindTag(const std::vector<TiffEntry>& directory, uint16_t tag);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_TIFF_H_
