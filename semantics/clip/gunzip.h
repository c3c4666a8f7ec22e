// SPDX-License-Identifier: BSD-3-Clause
// Unpacks gzip data in memory.

#ifndef FREEGS_SEMANTICS_CLIP_GUNZIP_H_
#define FREEGS_SEMANTICS_CLIP_GUNZIP_H_

#include <cstdint>
#include <string>
#include <string_view>

#include "core/status.h"

namespace freegs::semantics {

// True if the bytes begin like a gzip file.
bool IsGzip(std::string_view bytes);

// Returns the content of a gzip file of one member. kBadInput if the file is
// damaged, truncated, followed by other bytes, or larger than max_bytes when
// unpacked.
StatusOr<std::string> Gunzip(std::string_view bytes, uint64_t max_bytes);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_GUNZIP_H_
