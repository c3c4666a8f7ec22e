// SPDX-License-Identifier: BSD-3-Clause

#include "core/io/scratch_file.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <string>
#include <sys/mman.h>
#include <unistd.h>
#include <utility>

#include "core/io/write_all.h"

namespace freegs {
namespace {

namespace fs = std::filesystem;

class Descriptor {
 public:
  explicit Descriptor(int descriptor) : descriptor_(descriptor) {}
  ~Descriptor() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return descriptor_; }

 private:
  const int descriptor_;
};

Status ErrorOf(const fs::path& folder, const char* what, int error) {
  return InternalError(folder.string() + ": cannot " + what +
                       " a scratch file: " + std::strerror(error));
}

}  // namespace

ScratchFile::~ScratchFile() {
  if (data_ != nullptr) munmap(const_cast<std::byte*>(data_), size_);
}

ScratchFile::ScratchFile(ScratchFile&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)),
      size_(std::exchange(other.size_, 0)) {}

ScratchFile& ScratchFile::operator=(ScratchFile&& other) noexcept {
  // What was here goes away with `other`.
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

StatusOr<ScratchFile> ScratchFile::Write(
    const fs::path& folder, std::span<const std::span<const std::byte>> parts) {
  std::string path = (folder / "scratch_XXXXXX").string();
  const Descriptor file(mkostemp(path.data(), O_CLOEXEC));
  if (file.get() < 0) return ErrorOf(folder, "create", errno);
  if (unlink(path.c_str()) != 0) return ErrorOf(folder, "hide", errno);
  size_t size = 0;
  for (const std::span<const std::byte> part : parts) {
    // By write, not through the mapping: a full disk is an error here and
    // would be a signal there.
    if (!WriteAll(file.get(), part)) return ErrorOf(folder, "write", errno);
    size += part.size();
  }
  ScratchFile result;
  if (size == 0) return result;
  void* const data = mmap(nullptr, size, PROT_READ, MAP_SHARED, file.get(), 0);
  if (data == MAP_FAILED) return ErrorOf(folder, "map", errno);
  result.data_ = static_cast<const std::byte*>(data);
  result.size_ = size;
  return result;
}

}  // namespace freegs
