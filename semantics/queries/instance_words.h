// SPDX-License-Identifier: BSD-3-Clause
// What instances are called, where an encoder brings words to name things by.

#ifndef FREEGS_SEMANTICS_QUERIES_INSTANCE_WORDS_H_
#define FREEGS_SEMANTICS_QUERIES_INSTANCE_WORDS_H_

#include <span>
#include <string>
#include <vector>

#include "core/status.h"
#include "semantics/clip/clip_encoder.h"

namespace freegs::semantics {

// Words for each instance, best first: the words of each group that fit it
// best, said together ("red wooden box"), then each for itself. A group of
// which no word is more relevant to the instance than the canonical phrases
// (see Relevancy) says nothing. None for an instance whose vector is zero, and
// without a vocabulary.
//
// vectors: instances x dim, of length 1 or zero, in the encoder's space.
// vocabulary: groups of words of which one fits (colours, materials, things).
// Errors of the encoder.
StatusOr<std::vector<std::vector<std::string>>> NameInstances(
    std::span<const float> vectors,
    const std::vector<std::vector<std::string>>& vocabulary,
    ClipEncoder& encoder);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_QUERIES_INSTANCE_WORDS_H_
