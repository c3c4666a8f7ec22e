// SPDX-License-Identifier: BSD-3-Clause
// Writes to a file descriptor. For the files of this folder only.

#ifndef FREEGS_CORE_IO_WRITE_ALL_H_
#define FREEGS_CORE_IO_WRITE_ALL_H_

#include <cerrno>
#include <cstddef>
#include <span>
#include <unistd.h>

namespace freegs {

// Writes all bytes. Returns false, with errno set, when not everything could be
// written.
inline bool WriteAll(int descriptor, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written == 0) errno = ENOSPC;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
  return true;
}

}  // namespace freegs

#endif  // FREEGS_CORE_IO_WRITE_ALL_H_
