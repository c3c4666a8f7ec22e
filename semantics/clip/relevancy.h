// SPDX-License-Identifier: BSD-3-Clause
// How much a feature is like a text (LERF; Kerr et al. 2023).

#ifndef FREEGS_SEMANTICS_CLIP_RELEVANCY_H_
#define FREEGS_SEMANTICS_CLIP_RELEVANCY_H_

#include <span>
#include <vector>

#include "core/status.h"
#include "semantics/clip/clip_encoder.h"

namespace freegs::semantics {

// The relevancy of a feature to a text: the least, over the canonical texts, of
//   exp(10 cos(f, text)) / (exp(10 cos(f, text)) + exp(10 cos(f, canonical))).
// Above one half the feature is more like the text than like any of them.
//
// All are vectors of the feature's size; `canonical` holds one after another.
// Texts are of length 1, the feature of any length; one of length zero has
// relevancy one half. Without canonical texts it is 1.
float Relevancy(std::span<const float> feature,
                std::span<const float> text,
                std::span<const float> canonical);

// The vectors of the encoder's canonical_phrases(), one after another:
// `canonical` above. Errors as ClipEncoder::EncodeText.
StatusOr<std::vector<float>> EncodeCanonicalPhrases(ClipEncoder& encoder);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_RELEVANCY_H_
