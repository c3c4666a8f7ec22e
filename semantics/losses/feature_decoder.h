// SPDX-License-Identifier: BSD-3-Clause
// Decodes latents to the features of CLIP. Latents are what Gaussians carry, or
// what is blended from them at a pixel. The decoder is the MLP of FreeGS (eq.
// 4), or a linear map if the latents are principal components of features.
//
//   const FeatureDecoder decoder(RandomMlpDecoder(shape, seed));
//   std::vector<float> features(n * decoder.feature_dim());
//   FREEGS_RETURN_IF_ERROR(decoder.Decode(latents, pool, features));

#ifndef FREEGS_SEMANTICS_LOSSES_FEATURE_DECODER_H_
#define FREEGS_SEMANTICS_LOSSES_FEATURE_DECODER_H_

#include <span>
#include <utility>
#include <variant>

#include "core/parallel.h"
#include "core/status.h"
#include "semantics/losses/linear_decoder.h"
#include "semantics/losses/mlp_decoder.h"

namespace freegs::semantics {

class FeatureDecoder {
 public:
  // The Check() of the given decoder must be ok.
  explicit FeatureDecoder(LinearDecoder linear) : decoder_(std::move(linear)) {}
  explicit FeatureDecoder(MlpDecoder mlp) : decoder_(std::move(mlp)) {}

  int latent_dim() const;   // D
  int feature_dim() const;  // C

  // Null unless the decoder is of that kind.
  const LinearDecoder* linear() const {
    return std::get_if<LinearDecoder>(&decoder_);
  }
  const MlpDecoder* mlp() const { return std::get_if<MlpDecoder>(&decoder_); }
  MlpDecoder* mlp() { return std::get_if<MlpDecoder>(&decoder_); }

  // Writes features (n x C) of latents (n x D), row-major, for any number of
  // rows. A row does not depend on the other rows, and has the same bytes for
  // any number of threads. kInvalidArgument if sizes disagree.
  Status Decode(std::span<const float> latents,
                ThreadPool& pool,
                std::span<float> features) const;

 private:
  std::variant<LinearDecoder, MlpDecoder> decoder_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_FEATURE_DECODER_H_
