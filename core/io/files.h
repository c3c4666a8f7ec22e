// SPDX-License-Identifier: BSD-3-Clause
// Reads, writes and hashes whole files.

#ifndef FREEGS_CORE_IO_FILES_H_
#define FREEGS_CORE_IO_FILES_H_

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "core/cancellation.h"
#include "core/status.h"

namespace freegs {

// Reads a whole file. Returns kBadInput for a file that is larger than
// max_bytes, which guards against hostile or mistaken input, and for anything
// that is not a regular file.
StatusOr<std::string> ReadFile(const std::filesystem::path& path,
                               uint64_t max_bytes = uint64_t{1} << 33);

// Writes a temporary file beside `path`, flushes it to disk and renames it. So
// a reader sees either the old or the new content, never a part of it, and a
// power cut after the call does not bring the old content back:
//
//   FREEGS_RETURN_IF_ERROR(CreateFolders(folder));
//   FREEGS_RETURN_IF_ERROR(WriteFileAtomic(folder / "a.txt", text));
Status WriteFileAtomic(const std::filesystem::path& path,
                       std::string_view content);

// Writes a file in the same way. Its content comes in pieces, which need not be
// put together in memory.
Status WriteFileAtomic(const std::filesystem::path& path,
                       std::span<const std::string_view> pieces);

// Puts the content of a file that another program or library wrote on disk, or
// the names in a folder. Does nothing if it does not exist.
Status FlushToDisk(const std::filesystem::path& path);

// The suffix of a path with its letters A to Z in lower case, such as ".ply".
std::string LowerSuffix(const std::filesystem::path& path);

// Makes the folder and all missing folders above it.
Status CreateFolders(const std::filesystem::path& path);

// Whether there is anything of this name, also a link that leads nowhere.
bool IsNameTaken(const std::filesystem::path& path);

// Whether folder / name is a file below the folder, for a name that somebody
// else wrote: relative, without "..", and not the name of a folder. Links are
// not followed.
bool IsNameBelowFolder(std::string_view name);

// Whether `inner` is `outer` or lies below it, after links are resolved.
// Neither needs to exist. False for an empty path.
bool IsWithin(const std::filesystem::path& inner,
              const std::filesystem::path& outer);

// Makes a folder that the user named for results. Returns kBadInput when it
// cannot be written to, before work is spent on what would be lost.
Status PrepareOutputFolder(const std::filesystem::path& folder);

// Does the same with the folder of a file that the user named. Returns the path
// to write to: of a link the file that it leads to, which has the same suffix,
// so that WriteFileAtomic does not replace the link. Returns kBadInput for
// pipes and devices, too, which it would replace.
StatusOr<std::filesystem::path> PrepareOutputFile(
    const std::filesystem::path& file);

// The 128-bit XXH3 hash of bytes or of a file's content, as 32 hex digits. It
// detects changes, but it does not protect against forgery. HashFile is
// kInterrupted when cancelled, which is looked at after each MB.
std::string HashBytes(std::string_view bytes);
std::string HashBytes(std::span<const std::string_view> pieces);
StatusOr<std::string> HashFile(const std::filesystem::path& path,
                               const CancellationToken* cancellation = nullptr);

}  // namespace freegs

#endif  // FREEGS_CORE_IO_FILES_H_
