// SPDX-License-Identifier: BSD-3-Clause
// Letter case, white space, byte order marks, the order and lists of names,
// words of a shell, and the percent codes of paths and addresses.

#ifndef FREEGS_CORE_TEXT_H_
#define FREEGS_CORE_TEXT_H_

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/function_ref.h"

namespace freegs {

// 0 to 9, whatever the locale.
inline bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// Turns A to Z into a to z, whatever the locale, and leaves all other bytes.
std::string AsciiLower(std::string text);

// The part of `text` without blanks, tabs and ends of lines before and after
// it.
std::string_view Trimmed(std::string_view text);

// The text without the byte order mark that some editors put before the first
// line.
std::string_view WithoutByteOrderMark(std::string_view text);

// Orders names as people count: img2 before img10, and folder by folder. Of two
// different names one is always less. Photos are in this order everywhere.
bool NaturalLess(std::string_view a, std::string_view b);

// "a, b, c".
std::string Joined(const std::vector<std::string>& names);

// "a.jpg", "a.jpg, b.jpg and c.jpg" or "a.jpg, b.jpg, c.jpg, d.jpg and 7 more".
// All names but the first `shown` are only counted, unless it is only one.
std::string SomeNames(const std::vector<std::string>& names, size_t shown = 4);

// The text in single quotes, as a shell reads it.
std::string ShellQuoted(std::string_view text);

// The text as one word of a shell, in quotes where it has to be.
std::string ShellWord(std::string_view text);

// Replaces each byte for which `keep` returns false by '%' and two hex digits.
std::string PercentEncode(std::string_view text, FunctionRef<bool(char)> keep);

// The text that was encoded. Nothing when a '%' stands before anything but two
// hex digits.
std::optional<std::string> PercentDecode(std::string_view text);

}  // namespace freegs

#endif  // FREEGS_CORE_TEXT_H_
