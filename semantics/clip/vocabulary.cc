// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/vocabulary.h"

#include <utility>

#include "semantics/clip/relevancy.h"

namespace freegs::semantics {

StatusOr<Vocabulary> Vocabulary::Create(
    const std::vector<std::vector<std::string>>& groups, ClipEncoder& encoder) {
  Vocabulary vocabulary;
  if (groups.empty()) return vocabulary;
  FREEGS_ASSIGN_OR_RETURN(vocabulary.canonical_,
                          EncodeCanonicalPhrases(encoder));
  for (const std::vector<std::string>& texts : groups) {
    std::vector<Word>& group = vocabulary.groups_.emplace_back();
    for (const std::string& text : texts) {
      FREEGS_ASSIGN_OR_RETURN(TextEmbedding embedding,
                              EncodeModelText(text, encoder));
      group.push_back({text, std::move(embedding.values)});
    }
  }
  return vocabulary;
}

Vocabulary::Fit Vocabulary::BestOf(size_t group,
                                   std::span<const float> vector) const {
  Fit best;
  for (const Word& word : groups_[group]) {
    const float relevancy = Relevancy(vector, word.vector, canonical_);
    if (relevancy > best.relevancy) best = {&word.text, relevancy};
  }
  return best;
}

}  // namespace freegs::semantics
