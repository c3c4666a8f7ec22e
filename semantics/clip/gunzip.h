// SPDX-License-Identifier: BSD-3-Clause
// Reading gzip data held in memory.

#ifndef FREEGS_SEMANTICS_CLIP_GUNZIP_H_
#define FREEGS_SEMANTICS_CLIP_GUNZIP_H_

#include <cstdint>
#include <string>
#include <string_view>

#include "core/status.h"

namespace freegs::semantics {

// True if the bytes begin as a gzip file does.
bool IsGzip(std::string_view bytes);

// The content of a gzip file of one member. kBadInput if it is damaged,
// truncated, followed by more, or larger than max_bytes once unpacked.
StatusOr<std::string> Gunzip(std::string_view bytes, uint64_t max_bytes);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_GUNZIP_H_
