// SPDX-License-Identifier: BSD-3-Clause
// Latents, as they are blended or as Gaussians carry them, to CLIP's features
// (the MLP of FreeGS eq. 4): by that MLP, or by a linear map where latents are
// principal components of lifted features.

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
  // The decoder's own Check() must be ok.
  explicit FeatureDecoder(LinearDecoder linear) : decoder_(std::move(linear)) {}
  explicit FeatureDecoder(MlpDecoder mlp) : decoder_(std::move(mlp)) {}

  int latent_dim() const;   // D
  int feature_dim() const;  // C

  // The one it is; null for the other.
  const LinearDecoder* linear() const {
    return std::get_if<LinearDecoder>(&decoder_);
  }
  const MlpDecoder* mlp() const { return std::get_if<MlpDecoder>(&decoder_); }
  MlpDecoder* mlp() { return std::get_if<MlpDecoder>(&decoder_); }

  // features (n x C) of latents (n x D), row-major, any number of rows. Every
  // row is decoded for itself: what it becomes does not depend on the others.
  // The same bytes for any number of threads. kInvalidArgument when sizes
  // disagree.
  Status Decode(std::span<const float> latents,
                ThreadPool& pool,
                std::span<float> features) const;

 private:
  std::variant<LinearDecoder, MlpDecoder> decoder_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_FEATURE_DECODER_H_
