// SPDX-License-Identifier: BSD-3-Clause
// What CLIP does to a caption before it is cut into tokens.

#ifndef FREEGS_SEMANTICS_CLIP_CAPTION_TEXT_H_
#define FREEGS_SEMANTICS_CLIP_CAPTION_TEXT_H_

#include <string>
#include <string_view>
#include <vector>

namespace freegs::semantics {

// Resolves HTML character references twice, as the reference does; replaces
// each run of white space by one space; trims; makes lower case.
//
// The known references are numeric ones (&#8211; &#x2013;) and the names amp,
// lt, gt, quot, apos and nbsp. The two thousand other names of HTML stay as
// they are, and so do names that run into a word ("&ampx"). What ftfy does in
// the reference is left out: it repairs text that was decoded wrongly, and it
// simplifies quotes, ligatures and full width letters.
std::u32string CleanCaption(std::u32string_view text);

// Splits a clean caption as the reference does, into
//   <|startoftext|> | <|endoftext|> | 's | 't | 're | 've | 'm | 'll | 'd |
//   letters | one number | a run of anything else but white space
// The results are views into `text`.
std::vector<std::u32string_view> SplitCaption(std::u32string_view text);

// The words that stand for the tokens at the two ends of every caption.
inline constexpr std::u32string_view kStartOfText = U"<|startoftext|>";
inline constexpr std::u32string_view kEndOfText = U"<|endoftext|>";

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_CAPTION_TEXT_H_
