// SPDX-License-Identifier: BSD-3-Clause

#include "core/io/files.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <memory>
#include <system_error>
#include <unistd.h>
#include <vector>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/io/write_all.h"
#include "core/text.h"

namespace freegs {
namespace {

namespace fs = std::filesystem;

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

std::string Reason() { return std::strerror(errno); }

// Opens a regular file for reading. Not a pipe or a device, which could block
// or never end.
StatusOr<File> OpenRegular(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::status_known(status)) {
    return BadInputError(path.string() + ": cannot read: " + error.message());
  }
  if (!fs::exists(status)) {
    return BadInputError(path.string() + ": cannot read: no such file");
  }
  if (!fs::is_regular_file(status)) {
    return BadInputError(path.string() + ": not a regular file");
  }
  File file(std::fopen(path.c_str(), "rb"));
  if (file == nullptr) {
    return BadInputError(path.string() + ": cannot read: " + Reason());
  }
  return file;
}

std::string HexDigest(XXH128_hash_t hash) {
  char text[33];
  std::snprintf(text,
                sizeof(text),
                "%016llx%016llx",
                static_cast<unsigned long long>(hash.high64),
                static_cast<unsigned long long>(hash.low64));
  return text;
}

using HashState =
    std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)>;

HashState NewHashState() {
  HashState state(XXH3_createState(), XXH3_freeState);
  XXH3_128bits_reset(state.get());
  return state;
}

}  // namespace

StatusOr<std::string> ReadFile(const fs::path& path, uint64_t max_bytes) {
  FREEGS_ASSIGN_OR_RETURN(File file, OpenRegular(path));
  const Status too_large = BadInputError(path.string() + ": larger than " +
                                         std::to_string(max_bytes) + " bytes");
  std::error_code error;
  const uintmax_t size = fs::file_size(path, error);
  if (!error && size > max_bytes) return too_large;
  std::string content;
  std::vector<char> buffer(1 << 20);
  for (;;) {
    const size_t n = std::fread(buffer.data(), 1, buffer.size(), file.get());
    content.append(buffer.data(), n);
    if (content.size() > max_bytes) return too_large;  // It is growing.
    if (n < buffer.size()) break;
  }
  if (std::ferror(file.get()) != 0) {
    return BadInputError(path.string() + ": read error: " + Reason());
  }
  return content;
}

Status WriteFileAtomic(const fs::path& path, std::string_view content) {
  return WriteFileAtomic(path, std::span(&content, 1));
}

Status WriteFileAtomic(const fs::path& path,
                       std::span<const std::string_view> pieces) {
  const fs::path temporary = path.string() + ".part";
  const int descriptor =
      open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    return InternalError(temporary.string() + ": cannot write: " + Reason());
  }
  bool good =
      std::all_of(pieces.begin(), pieces.end(), [&](std::string_view piece) {
        return WriteAll(descriptor, std::as_bytes(std::span(piece)));
      });
  good = good && fsync(descriptor) == 0;
  std::string reason = good ? "" : Reason();
  if (close(descriptor) != 0 && good) {
    good = false;
    reason = Reason();
  }
  if (!good) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    return InternalError(temporary.string() + ": cannot write: " + reason);
  }
  std::error_code error;
  fs::rename(temporary, path, error);
  if (error) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    return InternalError(path.string() +
                         ": cannot replace: " + error.message());
  }
  return FlushToDisk(path.has_parent_path() ? path.parent_path() : ".");
}

Status FlushToDisk(const fs::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return Status();
  // Some file systems cannot flush folders.
  const bool good = fsync(descriptor) == 0 || errno == EINVAL;
  const std::string reason = Reason();
  close(descriptor);
  return good ? Status()
              : InternalError(path.string() + ": cannot write: " + reason);
}

std::string LowerSuffix(const fs::path& path) {
  return AsciiLower(path.extension().string());
}

Status CreateFolders(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) {
    return InternalError(path.string() +
                         ": cannot create folder: " + error.message());
  }
  return Status();
}

bool IsNameTaken(const fs::path& path) {
  std::error_code error;
  return fs::exists(fs::symlink_status(path, error));
}

bool IsNameBelowFolder(std::string_view name) {
  // The system would take what stands before a NUL for the whole name.
  if (name.find('\0') != std::string_view::npos) return false;
  const fs::path path(name);
  if (!path.is_relative() || !path.has_filename()) return false;
  return path.filename() != "." &&
         std::none_of(path.begin(), path.end(), [](const fs::path& part) {
           return part == "..";
         });
}

bool IsWithin(const fs::path& inner, const fs::path& outer) {
  if (inner.empty() || outer.empty()) return false;
  const auto resolved = [](const fs::path& path) {
    std::error_code error;
    const fs::path once =
        fs::weakly_canonical(fs::absolute(path, error), error);
    // A ".." after a missing folder may have hidden a link from the first call.
    return fs::weakly_canonical(once, error);
  };
  const fs::path relative = resolved(inner).lexically_relative(resolved(outer));
  return !relative.empty() && *relative.begin() != "..";
}

Status PrepareOutputFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error == std::errc::no_space_on_device) return CreateFolders(folder);
  std::string fault;
  if (error) {
    fault = "cannot create folder: " + error.message();
  } else if (access(folder.c_str(), W_OK | X_OK) != 0) {
    fault = "cannot write here: " + Reason();
  } else {
    return Status();
  }
  return BadInputError(folder.string() + ": " + fault +
                       "; give a folder that can be written to");
}

StatusOr<fs::path> PrepareOutputFile(const fs::path& file) {
  const auto refused = [&file](const std::string& fault) {
    return BadInputError(file.string() + ": " + fault);
  };
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!file.has_filename() || fs::is_directory(status)) {
    return refused("is a folder; give a file");
  }
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    return refused("not a regular file; give a file");
  }
  fs::path target = file;
  if (fs::is_symlink(file, error)) {
    target = fs::canonical(file, error);
    if (error) return refused("is a link that leads nowhere; give a file");
    // Many writers take the format from the suffix.
    if (LowerSuffix(target) != LowerSuffix(file)) {
      return refused("is a link to " + target.string() +
                     ", whose suffix is another; give a link that has it");
    }
  }
  FREEGS_RETURN_IF_ERROR(PrepareOutputFolder(
      target.has_parent_path() ? target.parent_path() : "."));
  return target;
}

std::string HashBytes(std::string_view bytes) {
  return HexDigest(XXH3_128bits(bytes.data(), bytes.size()));
}

std::string HashBytes(std::span<const std::string_view> pieces) {
  const HashState state = NewHashState();
  for (const std::string_view piece : pieces) {
    XXH3_128bits_update(state.get(), piece.data(), piece.size());
  }
  return HexDigest(XXH3_128bits_digest(state.get()));
}

StatusOr<std::string> HashFile(const fs::path& path,
                               const CancellationToken* cancellation) {
  FREEGS_ASSIGN_OR_RETURN(File file, OpenRegular(path));
  const HashState state = NewHashState();
  std::vector<char> buffer(1 << 20);
  size_t n = 0;
  while ((n = std::fread(buffer.data(), 1, buffer.size(), file.get())) > 0) {
    if (IsCancelled(cancellation)) {
      return InterruptedError(path.string() + ": stopped while reading it");
    }
    XXH3_128bits_update(state.get(), buffer.data(), n);
  }
  if (std::ferror(file.get()) != 0) {
    return BadInputError(path.string() + ": read error: " + Reason());
  }
  return HexDigest(XXH3_128bits_digest(state.get()));
}

}  // namespace freegs
