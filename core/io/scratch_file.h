// SPDX-License-Identifier: BSD-3-Clause
// Read-only memory that lies on disk, for arrays that do not fit in memory.

#ifndef FREEGS_CORE_IO_SCRATCH_FILE_H_
#define FREEGS_CORE_IO_SCRATCH_FILE_H_

#include <cstddef>
#include <filesystem>
#include <span>

#include "core/status.h"

namespace freegs {

// Bytes that are written once and then read as if they were in memory:
//
//   const std::span<const std::byte> parts[] = {std::as_bytes(values)};
//   FREEGS_ASSIGN_OR_RETURN(const ScratchFile file,
//                           ScratchFile::Write(folder, parts));
//   const auto* stored = reinterpret_cast<const float*>(file.data());
//
// The system reads them from the disk when they are needed, and drops them from
// memory when memory is short. The file loses its name before anything is
// written to it. So nobody else can open, change or shorten it, and the disk
// space is free again when the object or the program ends, for whatever reason.
class ScratchFile {
 public:
  ScratchFile() = default;
  ~ScratchFile();
  ScratchFile(ScratchFile&& other) noexcept;
  ScratchFile& operator=(ScratchFile&& other) noexcept;
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  // Writes the parts one after another to a new file in `folder`, which must
  // exist. Returns kInternal, with the folder's name, when the folder cannot be
  // written to, when the disk is full, or when the file cannot be mapped into
  // memory. Nothing is left behind then.
  static StatusOr<ScratchFile> Write(
      const std::filesystem::path& folder,
      std::span<const std::span<const std::byte>> parts);

  // Points to the beginning of a memory page; null when size() is 0.
  const std::byte* data() const { return data_; }
  size_t size() const { return size_; }

 private:
  const std::byte* data_ = nullptr;
  size_t size_ = 0;
};

}  // namespace freegs

#endif  // FREEGS_CORE_IO_SCRATCH_FILE_H_
