// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/named_wholes.h"

#include <algorithm>
#include <cstddef>

namespace freegs::semantics {
namespace {

constexpr double kLeastGain = 0.02;

}  // namespace

std::vector<WholePair> FindNamedWholes(std::span<const InstancePair> pairs,
                                       const InstanceVectors& alone,
                                       const InstanceVectors& together,
                                       const KnownThings& things) {
  const Vocabulary& vocabulary = things.vocabulary;
  const auto thing = [&](const InstanceVectors& vectors, size_t row) {
    const auto dim = static_cast<size_t>(vectors.dim);
    return vocabulary.Thing(std::span(vectors.vectors).subspan(row * dim, dim));
  };
  std::vector<WholePair> wholes;
  for (size_t k = 0; k < pairs.size(); ++k) {
    const Vocabulary::Fit whole = thing(together, k);
    const Vocabulary::Fit a = thing(alone, pairs[k].a);
    const Vocabulary::Fit b = thing(alone, pairs[k].b);
    // Chance makes a thing of two others, but seldom of the kind that one of
    // them looks like.
    if (whole.word == nullptr ||
        (whole.word != a.word && whole.word != b.word)) {
      continue;
    }
    const double part = std::max(a.relevancy, b.relevancy);
    if (whole.relevancy >= things.min_confidence &&
        whole.relevancy >= part + kLeastGain) {
      wholes.push_back({pairs[k], whole.relevancy});
    }
  }
  return wholes;
}

}  // namespace freegs::semantics
