// SPDX-License-Identifier: BSD-3-Clause
// Whole-file reading and atomic writing.

#ifndef FREEGS_CORE_IO_FILES_H_
#define FREEGS_CORE_IO_FILES_H_

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/status.h"

namespace freegs {

// The whole file. Refuses files larger than max_bytes (a guard against hostile
// or mistaken input) and anything that is not a regular file.
StatusOr<std::string> ReadFile(const std::filesystem::path& path,
                               uint64_t max_bytes = uint64_t{1} << 33);

// Writes to a temporary file beside `path`, flushes it to disk and renames it:
// a reader sees the old content or the new, never a part.
Status WriteFileAtomic(const std::filesystem::path& path,
                       std::string_view content);

// mkdir -p.
Status CreateFolders(const std::filesystem::path& path);

// 128-bit content hash as 32 hex digits (XXH3). Not cryptographic: it detects
// change, not malice.
std::string HashBytes(std::string_view bytes);
StatusOr<std::string> HashFile(const std::filesystem::path& path);

}  // namespace freegs

#endif  // FREEGS_CORE_IO_FILES_H_
