// SPDX-License-Identifier: BSD-3-Clause
// Names instances, with the words that come with an encoder.

#ifndef FREEGS_SEMANTICS_QUERIES_INSTANCE_WORDS_H_
#define FREEGS_SEMANTICS_QUERIES_INSTANCE_WORDS_H_

#include <span>
#include <string>
#include <vector>

#include "semantics/clip/vocabulary.h"

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
// instance than the canonical phrases. There are no words for an instance whose
// vector is zero, and without a vocabulary.
//
// An instance that is no known thing (Vocabulary::Thing), or one of less
// relevancy than min_confidence, has no words. The threshold belongs to the
// model (docs/clip.md says how that of the small one was found); 0 keeps all
// words.
//
// vectors: instances x dim, of length 1 or zero, in the space of the encoder.
InstanceNames NameInstances(std::span<const float> vectors,
                            int dim,
                            const Vocabulary& vocabulary,
                            double min_confidence);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_QUERIES_INSTANCE_WORDS_H_
