// SPDX-License-Identifier: BSD-3-Clause
// Text for an HTML page.

#ifndef FREEGS_STAGES_EXPORT_HTML_H_
#define FREEGS_STAGES_EXPORT_HTML_H_

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

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EXPORT_HTML_H_
