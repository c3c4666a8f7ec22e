// SPDX-License-Identifier: BSD-3-Clause
// What CLIP does to a caption before it is cut into tokens.

#ifndef FREEGS_SEMANTICS_CLIP_CAPTION_TEXT_H_
#define FREEGS_SEMANTICS_CLIP_CAPTION_TEXT_H_

#include <string>
#include <string_view>
#include <vector>

namespace freegs::semantics {

// Resolves HTML character references twice, as the reference does, collapses
// white space to single spaces, trims, and makes lower case.
//
// Known references are numeric ones (&#8211; &#x2013;) and the names amp, lt,
// gt, quot, apos and nbsp; HTML's two thousand others stay as they are, and so
// do names run together with a word ("&ampx"). Not done: ftfy's repair of
// wrongly decoded text, and its straightening of quotes, ligatures and full
// width letters.
std::u32string CleanCaption(std::u32string_view text);

// The reference's split of a clean caption:
//   <|startoftext|> | <|endoftext|> | 's | 't | 're | 've | 'm | 'll | 'd |
//   letters | one number | a run of anything else but white space
// Views into `text`.
std::vector<std::u32string_view> SplitCaption(std::u32string_view text);

// The words that stand for the tokens at the ends of every caption.
inline constexpr std::u32string_view kStartOfText = U"<|startoftext|>";
inline constexpr std::u32string_view kEndOfText = U"<|endoftext|>";

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_CAPTION_TEXT_H_
