// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/mlp_decoder.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/random.h"
#include "semantics/losses/all_finite.h"
#include "semantics/losses/matrix_products.h"

namespace freegs::semantics {
namespace {

constexpr int kMaxSize = 1 << 16;
constexpr int64_t kRowsAtOnce = 2048;

void FillNormal(uint64_t seed,
                uint64_t stream,
                double variance,
                std::span<float> values) {
  const double deviation = std::sqrt(variance);
  for (size_t k = 0; k < values.size(); ++k) {
    values[k] = static_cast<float>(deviation * RandomNormal(seed, stream, k));
  }
}

// The first layer together with the normalisation: relu(weights r + biases).
struct HiddenLayer {
  std::vector<float> weights;  // H x D
  std::vector<float> biases;   // H
};

HiddenLayer Normalized(const MlpDecoder& decoder) {
  const MlpParts<const float> parts = decoder.parts();
  const auto latent = static_cast<size_t>(decoder.shape.latent_dim);
  HiddenLayer layer;
  layer.weights.resize(parts.hidden_weights.size());
  layer.biases.resize(parts.scales.size());
  for (size_t h = 0; h < layer.biases.size(); ++h) {
    const double scale =
        parts.scales[h] /
        std::sqrt(decoder.running_variances[h] + MlpDecoder::kEpsilon);
    layer.biases[h] =
        static_cast<float>(parts.shifts[h] - scale * decoder.running_means[h]);
    for (size_t k = h * latent; k < (h + 1) * latent; ++k) {
      layer.weights[k] = static_cast<float>(scale * parts.hidden_weights[k]);
    }
  }
  return layer;
}

}  // namespace

size_t MlpShape::num_parameters() const {
  const auto hidden = static_cast<size_t>(hidden_dim);
  return hidden * (static_cast<size_t>(latent_dim) + 2 + feature_dim) +
         feature_dim;
}

Status MlpShape::Check() const {
  for (const int size : {latent_dim, hidden_dim, feature_dim}) {
    FREEGS_RETURN_IF_ERROR(CheckDecoderSize(size));
  }
  return Status();
}

Status CheckDecoderSize(int size) {
  if (size >= 1 && size <= kMaxSize) return Status();
  return InvalidArgumentError("a layer of the decoder of size " +
                              std::to_string(size) + ", not 1 to " +
                              std::to_string(kMaxSize));
}

Status MlpDecoder::Check() const {
  FREEGS_RETURN_IF_ERROR(shape.Check());
  const auto hidden = static_cast<size_t>(shape.hidden_dim);
  if (parameters.size() != shape.num_parameters() ||
      running_means.size() != hidden || running_variances.size() != hidden) {
    return InvalidArgumentError("the decoder's arrays are not of its shape");
  }
  if (!AllFinite(parameters) || !AllFinite(running_means) ||
      !AllFinite(running_variances)) {
    return InvalidArgumentError("the decoder is not finite");
  }
  if (*std::min_element(running_variances.begin(), running_variances.end()) <
      0) {
    return InvalidArgumentError("a variance of the decoder is below 0");
  }
  return Status();
}

MlpDecoder RandomMlpDecoder(const MlpShape& shape, uint64_t seed) {
  MlpDecoder decoder;
  decoder.shape = shape;
  decoder.parameters.resize(shape.num_parameters(), 0.0f);
  decoder.running_means.resize(shape.hidden_dim, 0.0f);
  decoder.running_variances.resize(shape.hidden_dim, 1.0f);
  const MlpParts<float> parts = decoder.parts();
  FillNormal(seed, 0, 2.0 / shape.latent_dim, parts.hidden_weights);
  std::fill(parts.scales.begin(), parts.scales.end(), 1.0f);
  FillNormal(seed,
             1,
             2.0 / shape.hidden_dim / shape.feature_dim,
             parts.output_weights);
  return decoder;
}

void DecodeWithMlp(const MlpDecoder& decoder,
                   std::span<const float> latents,
                   ThreadPool& pool,
                   std::span<float> features) {
  const MlpShape& shape = decoder.shape;
  const MlpParts<const float> parts = decoder.parts();
  const HiddenLayer layer = Normalized(decoder);
  const ConstRows all = AsRows(latents, shape.latent_dim);
  std::vector<float> hidden;
  for (int64_t begin = 0; begin < all.rows(); begin += kRowsAtOnce) {
    const int64_t count = std::min(kRowsAtOnce, all.rows() - begin);
    hidden.resize(count * shape.hidden_dim);
    ApplyLayer(AsRows(latents.subspan(begin * shape.latent_dim,
                                      count * shape.latent_dim),
                      shape.latent_dim),
               AsRows(layer.weights, shape.latent_dim),
               layer.biases,
               Activation::kRelu,
               pool,
               AsRows(hidden, shape.hidden_dim));
    ApplyLayer(AsRows(hidden, shape.hidden_dim),
               AsRows(parts.output_weights, shape.hidden_dim),
               parts.output_biases,
               Activation::kNone,
               pool,
               AsRows(features.subspan(begin * shape.feature_dim,
                                       count * shape.feature_dim),
                      shape.feature_dim));
  }
}

}  // namespace freegs::semantics
