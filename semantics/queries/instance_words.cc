// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/queries/instance_words.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "semantics/clip/relevancy.h"

namespace freegs::semantics {
namespace {

struct Word {
  std::string text;
  std::vector<float> vector;
};

struct Fit {
  const Word* word = nullptr;
  float relevancy = 0.5f;  // What a word must exceed.
};

Fit BestOf(const std::vector<Word>& group,
           std::span<const float> vector,
           std::span<const float> canonical) {
  Fit best;
  for (const Word& word : group) {
    const float relevancy = Relevancy(vector, word.vector, canonical);
    if (relevancy > best.relevancy) best = {&word, relevancy};
  }
  return best;
}

bool IsNonzero(std::span<const float> vector) {
  return std::any_of(
      vector.begin(), vector.end(), [](float value) { return value != 0; });
}

// The words of all groups together, then alone, the most relevant first.
std::vector<std::string> Say(std::vector<Fit> fits) {
  std::vector<std::string> words;
  std::string together;
  for (const Fit& fit : fits) {
    together += (together.empty() ? "" : " ") + fit.word->text;
  }
  if (!fits.empty()) words.push_back(together);
  if (fits.size() < 2) return words;
  std::stable_sort(fits.begin(), fits.end(), [](const Fit& a, const Fit& b) {
    return a.relevancy > b.relevancy;
  });
  for (const Fit& fit : fits) words.push_back(fit.word->text);
  return words;
}

}  // namespace

StatusOr<InstanceNames> NameInstances(
    std::span<const float> vectors,
    const std::vector<std::vector<std::string>>& vocabulary,
    double min_confidence,
    ClipEncoder& encoder) {
  const auto dim = static_cast<size_t>(encoder.embedding_dim());
  InstanceNames names;
  names.words.resize(vectors.size() / dim);
  if (vocabulary.empty()) return names;
  FREEGS_ASSIGN_OR_RETURN(const std::vector<float> canonical,
                          EncodeCanonicalPhrases(encoder));
  std::vector<std::vector<Word>> groups;
  for (const std::vector<std::string>& texts : vocabulary) {
    std::vector<Word>& group = groups.emplace_back();
    for (const std::string& text : texts) {
      FREEGS_ASSIGN_OR_RETURN(TextEmbedding embedding,
                              encoder.EncodeText(text));
      group.push_back({text, std::move(embedding.values)});
    }
  }
  for (size_t i = 0; i < names.words.size(); ++i) {
    const std::span<const float> vector = vectors.subspan(i * dim, dim);
    std::vector<Fit> fits;
    double confidence = 0;  // Ends as that of the last group.
    for (const std::vector<Word>& group : groups) {
      const Fit fit = BestOf(group, vector, canonical);
      if (fit.word != nullptr) fits.push_back(fit);
      confidence = fit.word != nullptr ? fit.relevancy : 0;
    }
    if (confidence < min_confidence && IsNonzero(vector)) {
      fits.clear();
      ++names.num_withheld;
    }
    names.words[i] = Say(std::move(fits));
  }
  return names;
}

}  // namespace freegs::semantics
