// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/queries/gaussian_relevancy.h"

#include <algorithm>
#include <cstdint>
#include <string>

#include "semantics/clip/relevancy.h"

namespace freegs::semantics {

StatusOr<std::vector<float>> GaussianRelevancy(const Idsf& field,
                                               const FeatureDecoder& decoder,
                                               std::span<const float> texts,
                                               std::span<const float> canonical,
                                               ThreadPool& pool) {
  // Decoded features of at most this many Gaussians are in memory at a time.
  constexpr size_t kRows = 8192;
  const auto latent_dim = static_cast<size_t>(decoder.latent_dim());
  const auto dim = static_cast<size_t>(decoder.feature_dim());
  const size_t count = field.instances.size();
  if (field.feature_dim != decoder.latent_dim() ||
      field.features.size() != count * latent_dim) {
    return InvalidArgumentError(
        "the field has vectors of " + std::to_string(field.feature_dim) +
        " numbers, its decoder takes " + std::to_string(latent_dim));
  }
  if (texts.size() % dim != 0 || canonical.size() % dim != 0) {
    return InvalidArgumentError("texts are not vectors of " +
                                std::to_string(dim) + " numbers");
  }
  const size_t num_texts = texts.size() / dim;
  std::vector<float> result(count * num_texts);
  std::vector<float> features;
  for (size_t first = 0; first < count; first += kRows) {
    const size_t rows = std::min(kRows, count - first);
    features.resize(rows * dim);
    FREEGS_RETURN_IF_ERROR(
        decoder.Decode(std::span(field.features)
                           .subspan(first * latent_dim, rows * latent_dim),
                       pool,
                       features));
    pool.ParallelFor(
        0,
        static_cast<int64_t>(rows),
        64,
        [&](int64_t begin, int64_t end, int) {
          for (auto row = static_cast<size_t>(begin);
               row < static_cast<size_t>(end);
               ++row) {
            const auto latent =
                std::span(field.features)
                    .subspan((first + row) * latent_dim, latent_dim);
            if (std::ranges::all_of(latent, [](float x) { return x == 0; })) {
              continue;
            }
            const auto feature = std::span(features).subspan(row * dim, dim);
            for (size_t t = 0; t < num_texts; ++t) {
              result[(first + row) * num_texts + t] =
                  Relevancy(feature, texts.subspan(t * dim, dim), canonical);
            }
          }
        });
  }
  return result;
}

}  // namespace freegs::semantics
