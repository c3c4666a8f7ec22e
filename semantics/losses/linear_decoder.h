// SPDX-License-Identifier: BSD-3-Clause
// Decodes latents that are coordinates in a linear basis of the features, such
// as principal components.

#ifndef FREEGS_SEMANTICS_LOSSES_LINEAR_DECODER_H_
#define FREEGS_SEMANTICS_LOSSES_LINEAR_DECODER_H_

#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

// F = B r + mean. The basis is not trained.
struct LinearDecoder {
  int latent_dim = 0;        // D
  int feature_dim = 0;       // C
  std::vector<float> basis;  // B, C x D, row-major.
  std::vector<float> mean;   // C

  // kInvalidArgument for sizes that disagree or are out of range, and for
  // values that are not finite.
  Status Check() const;
};

// Writes features (n x C) of latents (n x D), both row-major.
void DecodeLinear(const LinearDecoder& decoder,
                  std::span<const float> latents,
                  ThreadPool& pool,
                  std::span<float> features);

// Adds feature_gradients (n x C) times B to latent_gradients (n x D).
void AddLinearGradients(const LinearDecoder& decoder,
                        std::span<const float> feature_gradients,
                        ThreadPool& pool,
                        std::span<float> latent_gradients);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_LINEAR_DECODER_H_
