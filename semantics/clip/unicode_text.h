// SPDX-License-Identifier: BSD-3-Clause
// The part of Unicode that the tokeniser of CLIP needs. It does not use the
// locale, so that results are the same on every machine.

#ifndef FREEGS_SEMANTICS_CLIP_UNICODE_TEXT_H_
#define FREEGS_SEMANTICS_CLIP_UNICODE_TEXT_H_

#include <string>
#include <string_view>

namespace freegs::semantics {

// Returns the code points of UTF-8 text. Every byte that is not part of a valid
// sequence becomes U+FFFD. Overlong sequences, surrogates and code points
// beyond U+10FFFF are not valid.
std::u32string DecodeUtf8(std::string_view text);

// Surrogates and code points beyond U+10FFFF become U+FFFD.
std::string EncodeUtf8(std::u32string_view text);

bool IsLetter(char32_t c);      // \p{L}
bool IsNumber(char32_t c);      // \p{N}
bool IsWhiteSpace(char32_t c);  // The property White_Space.

// Lower-cases like str.lower() of Python: U+0130 becomes two code points, and a
// sigma at the end of a word takes its final form.
std::u32string LowerCase(std::u32string_view text);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_UNICODE_TEXT_H_
