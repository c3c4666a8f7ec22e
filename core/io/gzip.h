// SPDX-License-Identifier: BSD-3-Clause
// Packs and unpacks gzip data in memory.

#ifndef FREEGS_CORE_IO_GZIP_H_
#define FREEGS_CORE_IO_GZIP_H_

#include <cstdint>
#include <string>
#include <string_view>

#include "core/status.h"

namespace freegs {

// Returns a gzip file of one member. It holds no time and no name, so the same
// content gives the same bytes.
StatusOr<std::string> Gzip(std::string_view content);

// True if the bytes begin like a gzip file.
bool IsGzip(std::string_view bytes);

// Returns the content of a gzip file of one member. kBadInput if the file is
// damaged, truncated, followed by other bytes, or larger than max_bytes when
// unpacked.
StatusOr<std::string> Gunzip(std::string_view bytes, uint64_t max_bytes);

// Returns the first num_bytes of the content, or all of it if it is shorter. So
// a format's header can say how much there is to unpack. kBadInput if the file
// is damaged or ends before that; what comes after is not looked at.
StatusOr<std::string> GunzipBeginning(std::string_view bytes,
                                      uint64_t num_bytes);

}  // namespace freegs

#endif  // FREEGS_CORE_IO_GZIP_H_
