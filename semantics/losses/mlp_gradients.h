// SPDX-License-Identifier: BSD-3-Clause
// The MLP decoder in training: forward with the statistics of the batch, and
// backward.

#ifndef FREEGS_SEMANTICS_LOSSES_MLP_GRADIENTS_H_
#define FREEGS_SEMANTICS_LOSSES_MLP_GRADIENTS_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "semantics/losses/mlp_decoder.h"

namespace freegs::semantics {

// What MlpBackward needs to know of the forward pass, for S rows.
struct MlpBatch {
  int64_t rows = 0;
  std::vector<float> latents;          // S x D
  std::vector<float> normalized;       // S x H: (W1 r - mean) / deviation
  std::vector<float> hidden;           // S x H, after the ReLU
  std::vector<double> means;           // H, of W1 r in this batch
  std::vector<double> variances;       // H, the mean square about the mean
  std::vector<double> inv_deviations;  // H: 1 / sqrt(variance + epsilon)

  // False if the latents were not finite, or so large that the statistics do
  // not fit in floats.
  bool statistics_finite() const;
};

// Writes features (S x C) of latents (S x D), normalised by the mean and
// variance of this batch. A batch of one row has variance 0, and normalises to
// 0.
void MlpForward(const MlpDecoder& decoder,
                std::span<const float> latents,
                ThreadPool& pool,
                MlpBatch* batch,
                std::span<float> features);

// Sets running += momentum * (statistics of the batch - running), with the
// unbiased estimate of the variance, as batch normalisation does (Ioffe and
// Szegedy 2015). A batch of one row leaves the running variance as it is,
// because it has no such estimate; an empty batch changes nothing.
void UpdateRunningStatistics(const MlpBatch& batch,
                             double momentum,
                             MlpDecoder* decoder);

// Adds dL/dparameters (see PartsOf) and dL/dlatents (S x D), given dL/dfeatures
// (S x C) and the batch that MlpForward filled with the same parameters.
void MlpBackward(const MlpDecoder& decoder,
                 const MlpBatch& batch,
                 std::span<const float> feature_gradients,
                 ThreadPool& pool,
                 std::span<float> parameter_gradients,
                 std::span<float> latent_gradients);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_MLP_GRADIENTS_H_
