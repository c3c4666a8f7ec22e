// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/queries/text_query.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "semantics/clip/relevancy.h"

namespace freegs::semantics {
namespace {

Status CheckVectors(const InstanceFeatures& features,
                    std::span<const float> vectors,
                    const std::string& what) {
  const auto dim = static_cast<size_t>(features.dim);
  if (features.dim < 1 || vectors.size() % dim != 0) {
    return InvalidArgumentError(what + " of " + std::to_string(vectors.size()) +
                                " numbers for instance features of " +
                                std::to_string(features.dim));
  }
  if (!std::all_of(vectors.begin(), vectors.end(), [](float value) {
        return std::isfinite(value);
      })) {
    return InvalidArgumentError(what + " is not finite");
  }
  return Status();
}

Status CheckVector(const InstanceFeatures& features,
                   std::span<const float> vector,
                   const std::string& what) {
  FREEGS_RETURN_IF_ERROR(CheckVectors(features, vector, what));
  if (vector.size() != static_cast<size_t>(features.dim) ||
      std::all_of(
          vector.begin(), vector.end(), [](float v) { return v == 0; })) {
    return InvalidArgumentError(what + " is not one vector, or zero");
  }
  return Status();
}

double Cosine(std::span<const float> a, std::span<const float> b) {
  double dot = 0;
  double square_a = 0;
  double square_b = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    dot += static_cast<double>(a[i]) * b[i];
    square_a += static_cast<double>(a[i]) * a[i];
    square_b += static_cast<double>(b[i]) * b[i];
  }
  return dot / std::sqrt(square_a * square_b);
}

// Returns make(row) for the instances that may answer, by descending score, as
// far as score(hit) is at least min_score.
template <typename Hit, typename Make, typename Score>
StatusOr<std::vector<Hit>> Best(const InstanceFeatures& features,
                                std::span<const uint8_t> is_background,
                                bool background,
                                int max_hits,
                                double min_score,
                                const Make& make,
                                const Score& score) {
  if (!is_background.empty() && is_background.size() != features.size()) {
    return InvalidArgumentError(
        "background flags of " + std::to_string(is_background.size()) +
        " instances for features of " + std::to_string(features.size()));
  }
  std::vector<Hit> hits;
  for (size_t i = 0; i < features.size(); ++i) {
    if (!features.known(i)) continue;
    if (!background && !is_background.empty() && is_background[i] != 0) {
      continue;
    }
    const Hit hit = make(i);
    if (score(hit) >= min_score) hits.push_back(hit);
  }
  // Hits are in the order of ids, which a stable sort keeps among equals.
  std::stable_sort(
      hits.begin(), hits.end(), [&score](const Hit& a, const Hit& b) {
        return score(a) > score(b);
      });
  if (max_hits > 0 && hits.size() > static_cast<size_t>(max_hits)) {
    hits.resize(static_cast<size_t>(max_hits));
  }
  return hits;
}

}  // namespace

Status TextQueryOptions::Check() const {
  if (!(min_relevancy >= 0 && min_relevancy <= 1)) {
    return InvalidArgumentError("min_relevancy must be 0 .. 1");
  }
  if (max_hits < 0) return InvalidArgumentError("max_hits must be at least 0");
  return Status();
}

Status ExampleQueryOptions::Check() const {
  if (max_hits < 0) return InvalidArgumentError("max_hits must be at least 0");
  return Status();
}

StatusOr<std::vector<TextHit>> QueryText(
    const InstanceFeatures& features,
    std::span<const float> text,
    std::span<const float> canonical,
    const TextQueryOptions& options,
    std::span<const uint8_t> is_background) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  FREEGS_RETURN_IF_ERROR(CheckVector(features, text, "a text"));
  FREEGS_RETURN_IF_ERROR(
      CheckVectors(features, canonical, "the canonical texts"));
  return Best<TextHit>(
      features,
      is_background,
      options.background,
      options.max_hits,
      options.min_relevancy,
      [&](size_t i) {
        const std::span<const float> row = features.row(i);
        return TextHit{static_cast<int>(i) + 1,
                       Relevancy(row, text, canonical),
                       Cosine(row, text)};
      },
      [](const TextHit& hit) { return hit.relevancy; });
}

StatusOr<std::vector<ExampleHit>> QueryExample(
    const InstanceFeatures& features,
    std::span<const float> image_vector,
    const ExampleQueryOptions& options,
    std::span<const uint8_t> is_background) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  FREEGS_RETURN_IF_ERROR(CheckVector(features, image_vector, "a picture"));
  return Best<ExampleHit>(
      features,
      is_background,
      options.background,
      options.max_hits,
      /*min_score=*/-HUGE_VAL,
      [&](size_t i) {
        return ExampleHit{static_cast<int>(i) + 1,
                          Cosine(features.row(i), image_vector)};
      },
      [](const ExampleHit& hit) { return hit.cosine; });
}

}  // namespace freegs::semantics
