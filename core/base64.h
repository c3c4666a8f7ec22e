// SPDX-License-Identifier: BSD-3-Clause
// Binary data as text (RFC 4648, section 4).

#ifndef FREEGS_CORE_BASE64_H_
#define FREEGS_CORE_BASE64_H_

#include <string>
#include <string_view>

#include "core/status.h"

namespace freegs {

// Encodes with padding and without line breaks.
std::string EncodeBase64(std::string_view bytes);

// kBadInput for anything but such a text: other characters, white space among
// them, a length that is no multiple of four, or bits that stand for no byte.
StatusOr<std::string> DecodeBase64(std::string_view text);

}  // namespace freegs

#endif  // FREEGS_CORE_BASE64_H_
