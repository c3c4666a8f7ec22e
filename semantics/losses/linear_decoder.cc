// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/linear_decoder.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "semantics/losses/matrix_products.h"
#include "semantics/losses/mlp_decoder.h"

namespace freegs::semantics {

Status LinearDecoder::Check() const {
  FREEGS_RETURN_IF_ERROR(CheckDecoderSize(latent_dim));
  FREEGS_RETURN_IF_ERROR(CheckDecoderSize(feature_dim));
  const auto channels = static_cast<size_t>(feature_dim);
  if (basis.size() != channels * latent_dim || mean.size() != channels) {
    return InvalidArgumentError(
        "the basis or the mean of the linear decoder is not of its size");
  }
  const auto finite = [](float value) { return std::isfinite(value); };
  if (!std::all_of(basis.begin(), basis.end(), finite) ||
      !std::all_of(mean.begin(), mean.end(), finite)) {
    return InvalidArgumentError("the linear decoder is not finite");
  }
  return Status();
}

void DecodeLinear(const LinearDecoder& decoder,
                  std::span<const float> latents,
                  ThreadPool& pool,
                  std::span<float> features) {
  ApplyLayer(AsRows(latents, decoder.latent_dim),
             AsRows(decoder.basis, decoder.latent_dim),
             decoder.mean,
             Activation::kNone,
             pool,
             AsRows(features, decoder.feature_dim));
}

void AddLinearGradients(const LinearDecoder& decoder,
                        std::span<const float> feature_gradients,
                        ThreadPool& pool,
                        std::span<float> latent_gradients) {
  AddProduct(AsRows(feature_gradients, decoder.feature_dim),
             AsRows(decoder.basis, decoder.latent_dim),
             pool,
             AsRows(latent_gradients, decoder.latent_dim));
}

}  // namespace freegs::semantics
