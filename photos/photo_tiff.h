// SPDX-License-Identifier: BSD-3-Clause
// Reads the tags of TIFF files and of EXIF blocks, which have the same
// structure. It reads no pixels, and it checks every offset and count.

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
  size_t offset = 0;  // Where the first value lies in the bytes.
};

// Reads the directories of a file. The bytes must outlive the reader.
// Source: TIFF Revision 6.0 (Adobe, 1992), section 2.
class TiffReader {
 public:
  // Returns kBadInput when the bytes do not begin with a classic TIFF header.
  // BigTIFF, whose offsets have 64 bits, is refused with advice.
  static StatusOr<TiffReader> Open(std::string_view bytes);

  size_t first_directory() const { return first_directory_; }
  bool little_endian() const { return little_endian_; }

  // Returns the tags of the directory at `offset`. Tags of an unknown type and
  // tags whose values lie outside the file are left out; the latter also set
  // `complete`, if given, to false. Returns kBadInput when the directory itself
  // does not lie inside the file.
  StatusOr<std::vector<TiffEntry>> Directory(size_t offset,
                                             bool* complete = nullptr) const;

  // Value `index` of an entry of type BYTE, SHORT or LONG; nothing for other
  // types.
  std::optional<uint32_t> Unsigned(const TiffEntry& entry,
                                   uint32_t index = 0) const;

  // The first value of an entry of type RATIONAL or of an unsigned type;
  // nothing for other types and when the denominator is 0.
  std::optional<double> Real(const TiffEntry& entry) const;

  // An ASCII value up to its first NUL, without spaces around it. Bytes outside
  // printable ASCII become '?'. Empty for other types.
  std::string Text(const TiffEntry& entry) const;

 private:
  TiffReader(std::string_view bytes, bool little_endian)
      : bytes_(bytes), little_endian_(little_endian) {}

  // Reads an unsigned integer of `size` bytes. The caller has checked the
  // range.
  uint32_t Load(size_t offset, int size) const;

  std::string_view bytes_;
  bool little_endian_ = true;
  size_t first_directory_ = 0;
};

// Returns the entry of a tag, or null.
const TiffEntry* FindTag(const std::vector<TiffEntry>& directory, uint16_t tag);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_TIFF_H_
