// SPDX-License-Identifier: BSD-3-Clause
// Opens a file of a folder whose name somebody else has chosen.

#ifndef FREEGS_STAGES_VIEW_OPEN_FILE_H_
#define FREEGS_STAGES_VIEW_OPEN_FILE_H_

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "core/status.h"

namespace freegs::stages {

// A regular file that is open for reading.
class OpenFile {
 public:
  // Takes the descriptor, which is closed with the object.
  OpenFile(int descriptor, uint64_t size)
      : descriptor_(descriptor), size_(size) {}
  ~OpenFile();
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  uint64_t size() const { return size_; }  // In bytes, when it was opened.

  // Reads up to `count` bytes from `offset` on. Returns the number of bytes, 0
  // at the end and on errors. Several threads may call it.
  size_t Read(uint64_t offset, char* bytes, size_t count) const;

 private:
  const int descriptor_;
  const uint64_t size_;
};

// Opens root / name. The root itself may be a link. kBadInput when the name is
// not that of a regular file, or when links or ".." in it lead out of the root;
// the file that is opened is the one that was checked, whoever changes links in
// between.
StatusOr<std::shared_ptr<const OpenFile>> OpenBelow(
    const std::filesystem::path& root, std::string_view name);

// The content type for a file name, by its extension.
std::string ContentType(std::string_view name);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEW_OPEN_FILE_H_
