// SPDX-License-Identifier: BSD-3-Clause
// Makes text safe for an HTML page.

#ifndef FREEGS_STAGES_EXPORT_HTML_H_
#define FREEGS_STAGES_EXPORT_HTML_H_

#include <string>
#include <string_view>

namespace freegs::stages {

// Replaces & < > " ' by entities, and control characters and bytes that are not
// UTF-8 by U+FFFD. The result is safe as text and inside quoted attributes.
std::string EscapeHtml(std::string_view text);

// Turns a relative path into a URL: every byte that is neither unreserved (RFC
// 3986, section 2.3) nor '/' is percent-encoded. The result needs no further
// escaping. A colon in its first part cannot be taken for the end of a scheme.
std::string EncodeUrlPath(std::string_view path);

// Makes JSON safe within a script element, whose end "</script>" it must not
// hold. It stays the same JSON.
std::string JsonForScript(std::string json);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EXPORT_HTML_H_
