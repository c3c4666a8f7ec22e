// SPDX-License-Identifier: BSD-3-Clause
// Text and numbers for an HTML page.

#ifndef FREEGS_STAGES_REPORT_HTML_H_
#define FREEGS_STAGES_REPORT_HTML_H_

#include <cstdint>
#include <string>
#include <string_view>

namespace freegs::stages {

// Replaces & < > " ' by entities, control characters and bytes that are not
// UTF-8 by U+FFFD: safe as text and inside quoted attributes.
std::string EscapeHtml(std::string_view text);

// A relative path as a URL: every byte that is not unreserved (RFC 3986,
// section 2.3) or '/' is percent-encoded. Needs no further escaping, and a
// first part with a colon cannot be taken for a scheme.
std::string EncodeUrlPath(std::string_view path);

// Fixed decimals; "–" when the value is not finite.
std::string FormatFixed(double value, int decimals);

// 48211 -> "48,211".
std::string FormatCount(int64_t count);

// "1.4 s", "45 s", "3 min 05 s", "1 h 02 min".
std::string FormatSeconds(double seconds);

// "812 B", "1.4 MB" (powers of 1000).
std::string FormatBytes(double bytes);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_REPORT_HTML_H_
