// SPDX-License-Identifier: BSD-3-Clause
// The MLP decoder in training: with the statistics of the batch, and backwards.

#ifndef FREEGS_SEMANTICS_LOSSES_MLP_GRADIENTS_H_
#define FREEGS_SEMANTICS_LOSSES_MLP_GRADIENTS_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "semantics/losses/mlp_decoder.h"

namespace freegs::semantics {

// What the way back needs to know of the way forward. S rows.
struct MlpBatch {
  int64_t rows = 0;
  std::vector<float> latents;          // S x D
  std::vector<float> normalized;       // S x H: (W1 r - mean) / deviation
  std::vector<float> hidden;           // S x H, after the ReLU
  std::vector<double> means;           // H, of W1 r in this batch
  std::vector<double> variances;       // H, the mean square about the mean
  std::vector<double> inv_deviations;  // H: 1 / sqrt(variance + epsilon)

  // False when the latents were not, or so large that floats cannot hold the
  // statistics.
  bool statistics_finite() const;
};

// features (S x C) of latents (S x D), normalised by the mean and variance of
// this batch. A batch of one row has variance 0 and normalises to 0.
void MlpForward(const MlpDecoder& decoder,
                std::span<const float> latents,
                ThreadPool& pool,
                MlpBatch* batch,
                std::span<float> features);

// running += momentum (statistics of the batch - running), with the variance's
// unbiased estimate, as batch normalisation does it (Ioffe and Szegedy 2015).
// From one row there is no such estimate, and from none nothing at all.
void UpdateRunningStatistics(const MlpBatch& batch,
                             double momentum,
                             MlpDecoder* decoder);

// Adds dL/dparameters (see PartsOf) and dL/dlatents (S x D), given dL/dfeatures
// (S x C) and the batch of MlpForward with the same parameters.
void MlpBackward(const MlpDecoder& decoder,
                 const MlpBatch& batch,
                 std::span<const float> feature_gradients,
                 ThreadPool& pool,
                 std::span<float> parameter_gradients,
                 std::span<float> latent_gradients);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_MLP_GRADIENTS_H_
