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

struct InstanceNames {
  // Words for each instance, the best first; none where nothing fits.
  std::vector<std::vector<std::string>> words;

  // The number of instances whose words were not certain enough.
  int num_withheld = 0;
};

// From each group of the vocabulary the word that fits an instance best is
// taken; these words are first said together ("red wooden box"), and then each
// alone. A group is left out if none of its words is more relevant to the
// instance than the canonical phrases (see Relevancy()). There are no words for
// an instance whose vector is zero, and without a vocabulary.
//
// An encoder that has never seen a thing has a best word for it, too. The last
// group is that of things, and the confidence in a name is the relevancy of its
// word of that group: colours fit things that are not known, too. An instance
// whose confidence is below min_confidence, or which has no word of the
// last group, has no words. The threshold belongs to the model (docs/clip.md
// says how that of the small one was found); 0 keeps all words.
//
// vectors: instances x dim, of length 1 or zero, in the space of the encoder.
// vocabulary: groups of words of which one fits (colours, materials, things).
// Errors of the encoder.
StatusOr<InstanceNames> NameInstances(
    std::span<const float> vectors,
    const std::vector<std::vector<std::string>>& vocabulary,
    double min_confidence,
    ClipEncoder& encoder);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_QUERIES_INSTANCE_WORDS_H_
