// SPDX-License-Identifier: BSD-3-Clause
// As much of Unicode as CLIP's tokeniser needs, without the locale: results are
// the same on every machine.

#ifndef FREEGS_SEMANTICS_CLIP_UNICODE_TEXT_H_
#define FREEGS_SEMANTICS_CLIP_UNICODE_TEXT_H_

#include <string>
#include <string_view>

namespace freegs::semantics {

// Code points of UTF-8 text. Every byte that is not part of a valid sequence
// (also of an overlong one, a surrogate, or one past U+10FFFF) becomes U+FFFD.
std::u32string DecodeUtf8(std::string_view text);

// Surrogates and what lies past U+10FFFF become U+FFFD.
std::string EncodeUtf8(std::u32string_view text);

bool IsLetter(char32_t c);      // \p{L}
bool IsNumber(char32_t c);      // \p{N}
bool IsWhiteSpace(char32_t c);  // The property White_Space.

// Full lower-casing, with U+0130 becoming two code points and the final form of
// sigma, as Python's str.lower().
std::u32string LowerCase(std::u32string_view text);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_UNICODE_TEXT_H_
