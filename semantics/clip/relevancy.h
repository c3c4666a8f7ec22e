// SPDX-License-Identifier: BSD-3-Clause
// How well a feature matches a text (LERF; Kerr et al. 2023).

#ifndef FREEGS_SEMANTICS_CLIP_RELEVANCY_H_
#define FREEGS_SEMANTICS_CLIP_RELEVANCY_H_

#include <span>
#include <string>
#include <vector>

#include "core/status.h"
#include "semantics/clip/clip_encoder.h"

namespace freegs::semantics {

// Returns the relevancy of a feature to a text: the least value, over the
// canonical texts, of
//   exp(10 cos(f, text)) / (exp(10 cos(f, text)) + exp(10 cos(f, canonical))).
// If it is above one half, the feature is more like the text than like any of
// the canonical texts.
//
// All vectors have the size of the feature; `canonical` holds one after
// another. Texts have length 1; the feature has any length. A feature of length
// zero has relevancy one half. Without canonical texts the result is 1.
float Relevancy(std::span<const float> feature,
                std::span<const float> text,
                std::span<const float> canonical);

// ClipEncoder::EncodeText for words that somebody asks for. kInvalidArgument
// also for a text without words.
StatusOr<TextEmbedding> EncodeWords(const std::string& text,
                                    ClipEncoder& encoder);

// EncodeWords for words that the model brings. Where they cannot be encoded,
// the model is to blame and not the user: kBadInput names the words.
StatusOr<TextEmbedding> EncodeModelText(const std::string& text,
                                        ClipEncoder& encoder);

// Returns the vectors of encoder.canonical_phrases(), one after another, as
// Relevancy() takes them. Errors as EncodeModelText.
StatusOr<std::vector<float>> EncodeCanonicalPhrases(ClipEncoder& encoder);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_RELEVANCY_H_
