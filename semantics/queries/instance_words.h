// SPDX-License-Identifier: BSD-3-Clause
// Names instances, with the words that come with an encoder.

#ifndef FREEGS_SEMANTICS_QUERIES_INSTANCE_WORDS_H_
#define FREEGS_SEMANTICS_QUERIES_INSTANCE_WORDS_H_

#include <span>
#include <string>
#include <vector>

#include "core/status.h"
#include "semantics/clip/clip_encoder.h"

namespace freegs::semantics {

// Returns words for each instance, the best first. From each group of the
// vocabulary the word that fits best is taken; these words are first said
// together ("red wooden box"), and then each alone. A group is left out if none
// of its words is more relevant to the instance than the canonical phrases (see
// Relevancy()). There are no words for an instance whose vector is zero, and
// without a vocabulary.
//
// vectors: instances x dim, of length 1 or zero, in the space of the encoder.
// vocabulary: groups of words of which one fits (colours, materials, things).
// Errors of the encoder.
StatusOr<std::vector<std::vector<std::string>>> NameInstances(
    std::span<const float> vectors,
    const std::vector<std::vector<std::string>>& vocabulary,
    ClipEncoder& encoder);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_QUERIES_INSTANCE_WORDS_H_
