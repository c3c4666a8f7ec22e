// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/queries/instance_words.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace freegs::semantics {
namespace {

using Fit = Vocabulary::Fit;

bool IsNonzero(std::span<const float> vector) {
  return std::any_of(
      vector.begin(), vector.end(), [](float value) { return value != 0; });
}

// The words of all groups together, then alone, the most relevant first.
std::vector<std::string> Say(std::vector<Fit> fits) {
  std::vector<std::string> words;
  std::string together;
  for (const Fit& fit : fits) {
    together += (together.empty() ? "" : " ") + *fit.word;
  }
  if (!fits.empty()) words.push_back(together);
  if (fits.size() < 2) return words;
  std::stable_sort(fits.begin(), fits.end(), [](const Fit& a, const Fit& b) {
    return a.relevancy > b.relevancy;
  });
  for (const Fit& fit : fits) words.push_back(*fit.word);
  return words;
}

}  // namespace

InstanceNames NameInstances(std::span<const float> vectors,
                            int dim,
                            const Vocabulary& vocabulary,
                            double min_confidence) {
  const auto width = static_cast<size_t>(dim);
  InstanceNames names;
  names.words.resize(vectors.size() / width);
  if (vocabulary.num_groups() == 0) return names;
  for (size_t i = 0; i < names.words.size(); ++i) {
    const std::span<const float> vector = vectors.subspan(i * width, width);
    std::vector<Fit> fits;
    for (size_t group = 0; group < vocabulary.num_groups(); ++group) {
      const Fit fit = vocabulary.BestOf(group, vector);
      if (fit.word != nullptr) fits.push_back(fit);
    }
    const Fit thing = vocabulary.Thing(vector);
    const double confidence = thing.word != nullptr ? thing.relevancy : 0;
    if (confidence < min_confidence && IsNonzero(vector)) {
      fits.clear();
      ++names.num_withheld;
    }
    names.words[i] = Say(std::move(fits));
  }
  return names;
}

}  // namespace freegs::semantics
