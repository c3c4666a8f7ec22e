// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/feature_decoder.h"

#include <cstddef>
#include <string>

namespace freegs::semantics {

int FeatureDecoder::latent_dim() const {
  return mlp() ? mlp()->shape.latent_dim : linear()->latent_dim;
}

int FeatureDecoder::feature_dim() const {
  return mlp() ? mlp()->shape.feature_dim : linear()->feature_dim;
}

Status FeatureDecoder::Decode(std::span<const float> latents,
                              ThreadPool& pool,
                              std::span<float> features) const {
  const auto latent = static_cast<size_t>(latent_dim());
  const auto channels = static_cast<size_t>(feature_dim());
  if (latents.size() % latent != 0 || features.size() % channels != 0 ||
      latents.size() / latent != features.size() / channels) {
    return InvalidArgumentError(std::to_string(latents.size()) +
                                " latents of " + std::to_string(latent) +
                                " per row to decode to " +
                                std::to_string(features.size()) +
                                " features of " + std::to_string(channels));
  }
  if (mlp()) {
    DecodeWithMlp(*mlp(), latents, pool, features);
  } else {
    DecodeLinear(*linear(), latents, pool, features);
  }
  return Status();
}

}  // namespace freegs::semantics
