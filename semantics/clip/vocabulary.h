// SPDX-License-Identifier: BSD-3-Clause
// The words that come with an encoder, and how well they fit a vector.

#ifndef FREEGS_SEMANTICS_CLIP_VOCABULARY_H_
#define FREEGS_SEMANTICS_CLIP_VOCABULARY_H_

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/status.h"
#include "semantics/clip/clip_encoder.h"

namespace freegs::semantics {

class Vocabulary {
 public:
  struct Fit {
    const std::string* word = nullptr;  // A word of this vocabulary, or null.
    float relevancy = 0.5f;             // See Relevancy().
  };

  // groups: words of which one fits (colours, materials, and last things); may
  // be empty. Errors of the encoder.
  static StatusOr<Vocabulary> Create(
      const std::vector<std::vector<std::string>>& groups,
      ClipEncoder& encoder);

  size_t num_groups() const { return groups_.size(); }

  // The word of a group that is most relevant to a vector of the encoder. There
  // is none if the canonical phrases fit better, and for a zero vector.
  Fit BestOf(size_t group, std::span<const float> vector) const;

  // The word that BestOf finds in the last group, that of things, which there
  // must be. The relevancy is how sure it is what a vector shows. An encoder
  // that has never seen a thing has a best word for it, too, so what is low
  // means nothing. Colours do not count, because they fit things that are not
  // known.
  Fit Thing(std::span<const float> vector) const {
    return BestOf(groups_.size() - 1, vector);
  }

 private:
  struct Word {
    std::string text;
    std::vector<float> vector;
  };

  std::vector<std::vector<Word>> groups_;
  std::vector<float> canonical_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_VOCABULARY_H_
