// SPDX-License-Identifier: BSD-3-Clause
// The MLP that decodes blended latents to the features of CLIP (FreeGS eq. 4).

#ifndef FREEGS_SEMANTICS_LOSSES_MLP_DECODER_H_
#define FREEGS_SEMANTICS_LOSSES_MLP_DECODER_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

struct MlpShape {
  int latent_dim = 0;     // D
  int hidden_dim = 256;   // H
  int feature_dim = 512;  // C

  size_t num_parameters() const;
  Status Check() const;
};

// kInvalidArgument unless 1 <= size <= 65536.
Status CheckDecoderSize(int size);

// Where the parameters lie in one array. Gradients and moments have the same
// layout. T is float or const float.
template <typename T>
struct MlpParts {
  std::span<T> hidden_weights;  // W1, H x D, row-major.
  std::span<T> scales;          // H, of the batch normalisation
  std::span<T> shifts;          // H, likewise
  std::span<T> output_weights;  // W2, C x H
  std::span<T> output_biases;   // C
};

// The parts of `values`, which lie in it one after another in the order of
// MlpParts. `values` has shape.num_parameters() numbers and must outlive them.
template <typename T>
MlpParts<T> PartsOf(const MlpShape& shape, std::span<T> values) {
  const auto hidden = static_cast<size_t>(shape.hidden_dim);
  const auto take = [&values](size_t count) {
    const std::span<T> part = values.first(count);
    values = values.subspan(count);
    return part;
  };
  MlpParts<T> parts;
  parts.hidden_weights = take(hidden * shape.latent_dim);
  parts.scales = take(hidden);
  parts.shifts = take(hidden);
  parts.output_weights = take(hidden * shape.feature_dim);
  parts.output_biases = take(shape.feature_dim);
  return parts;
}

// F = W2 relu(scale (W1 r - mean) / sqrt(variance + epsilon) + shift) + bias.
// The first layer has no bias, because the mean would cancel it.
struct MlpDecoder {
  static constexpr double kEpsilon = 1e-5;  // Added to variances.

  MlpShape shape;
  std::vector<float> parameters;         // See PartsOf.
  std::vector<float> running_means;      // H, of W1 r over past batches.
  std::vector<float> running_variances;  // H, likewise; at least 0.

  MlpParts<const float> parts() const {
    return PartsOf(shape, std::span<const float>(parameters));
  }
  MlpParts<float> parts() { return PartsOf(shape, std::span(parameters)); }

  // kInvalidArgument for sizes that disagree or are out of range, for values
  // that are not finite, and for negative variances.
  Status Check() const;
};

// Draws weights from normal distributions (He et al. 2015). The variance is 2 /
// D in the first layer and 2 / (H C) in the second. With the usual 2 / H the
// decoded rows would have length sqrt(C); now they have about length 1, like
// the features of CLIP. The result depends on shape and seed only. The shape
// must be valid.
MlpDecoder RandomMlpDecoder(const MlpShape& shape, uint64_t seed);

// Writes features (n x C) of latents (n x D), normalised with the running
// statistics. Works in blocks of rows and needs little memory beside the
// result.
void DecodeWithMlp(const MlpDecoder& decoder,
                   std::span<const float> latents,
                   ThreadPool& pool,
                   std::span<float> features);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_MLP_DECODER_H_
