// SPDX-License-Identifier: BSD-3-Clause
// Memory that lies on disk, for arrays that would fill the machine's.

#ifndef FREEGS_CORE_IO_SCRATCH_FILE_H_
#define FREEGS_CORE_IO_SCRATCH_FILE_H_

#include <cstddef>
#include <filesystem>
#include <span>

#include "core/status.h"

namespace freegs {

// Bytes written once and then read as if they were in memory. The system reads
// them from the disk when needed and drops them when memory is short.
//
// The file loses its name before anything is written to it: nobody else can
// open, change or cut it, and its space is free again when this goes away,
// whatever ends the program.
class ScratchFile {
 public:
  ScratchFile() = default;
  ~ScratchFile();
  ScratchFile(ScratchFile&& other) noexcept;
  ScratchFile& operator=(ScratchFile&& other) noexcept;
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  // Writes the parts one after another to a new file in `folder`, which must
  // exist. kInternal, naming the folder, when it cannot be written, is full or
  // the file cannot be mapped; nothing is left behind then.
  static StatusOr<ScratchFile> Write(
      const std::filesystem::path& folder,
      std::span<const std::span<const std::byte>> parts);

  // At the beginning of a memory page. Not null unless size() is 0.
  const std::byte* data() const { return data_; }
  size_t size() const { return size_; }

 private:
  const std::byte* data_ = nullptr;
  size_t size_ = 0;
};

}  // namespace freegs

#endif  // FREEGS_CORE_IO_SCRATCH_FILE_H_
