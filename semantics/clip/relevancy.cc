// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/relevancy.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace freegs::semantics {
namespace {

// CLIP multiplies cosines by a learnt factor of about 100. LERF takes 10, so
// that there are values between yes and no.
constexpr double kTemperature = 10;

double Dot(std::span<const float> a, std::span<const float> b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    sum += static_cast<double>(a[i]) * b[i];
  }
  return sum;
}

}  // namespace

float Relevancy(std::span<const float> feature,
                std::span<const float> text,
                std::span<const float> canonical) {
  const double length = std::sqrt(Dot(feature, feature));
  const double scale = length > 0 ? kTemperature / length : 0;
  const double score = scale * Dot(feature, text);
  double relevancy = 1;
  for (size_t i = 0; i + feature.size() <= canonical.size() && !feature.empty();
       i += feature.size()) {
    const double other =
        scale * Dot(feature, canonical.subspan(i, feature.size()));
    relevancy = std::min(relevancy, 1 / (1 + std::exp(other - score)));
  }
  return static_cast<float>(relevancy);
}

StatusOr<TextEmbedding> EncodeWords(const std::string& text,
                                    ClipEncoder& encoder) {
  StatusOr<TextEmbedding> embedding = encoder.EncodeText(text);
  if (embedding.ok() && !embedding->has_words) {
    return InvalidArgumentError("there are no words in the text");
  }
  return embedding;
}

StatusOr<TextEmbedding> EncodeModelText(const std::string& text,
                                        ClipEncoder& encoder) {
  StatusOr<TextEmbedding> embedding = EncodeWords(text, encoder);
  if (embedding.status().code() == StatusCode::kInvalidArgument) {
    return BadInputError("model.json: the words \"" + text +
                         "\": " + embedding.status().message());
  }
  return embedding;
}

StatusOr<std::vector<float>> EncodeCanonicalPhrases(ClipEncoder& encoder) {
  std::vector<float> canonical;
  for (const std::string& phrase : encoder.canonical_phrases()) {
    FREEGS_ASSIGN_OR_RETURN(const TextEmbedding embedding,
                            EncodeModelText(phrase, encoder));
    canonical.insert(
        canonical.end(), embedding.values.begin(), embedding.values.end());
  }
  return canonical;
}

}  // namespace freegs::semantics
