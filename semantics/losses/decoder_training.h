// SPDX-License-Identifier: BSD-3-Clause
// Trains a FeatureDecoder together with the latents that it decodes.
//
//   DecoderTraining training({.learning_rate = 1e-4}, &decoder);
//   // In every step of training:
//   FREEGS_ASSIGN_OR_RETURN(const std::span<const float> features,
//                           training.Forward(latents, pool));
//   // Losses write dL/dfeatures to feature_gradients.
//   FREEGS_RETURN_IF_ERROR(
//       training.Backward(feature_gradients, pool, latent_gradients));
//   FREEGS_RETURN_IF_ERROR(training.Step(pool));

#ifndef FREEGS_SEMANTICS_LOSSES_DECODER_TRAINING_H_
#define FREEGS_SEMANTICS_LOSSES_DECODER_TRAINING_H_

#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"
#include "semantics/losses/array_adam.h"
#include "semantics/losses/feature_decoder.h"
#include "semantics/losses/mlp_gradients.h"
#include "splat/optim/adam.h"

namespace freegs::semantics {

struct DecoderTrainingOptions {
  double learning_rate = 1e-4;  // FreeGS, "CNN layers".

  Status Check() const;
};

// A linear decoder takes part as well: gradients pass through it to the
// latents, and Step() does nothing.
class DecoderTraining {
 public:
  // Keeps a pointer to the decoder, which must outlive this object.
  DecoderTraining(const DecoderTrainingOptions& options,
                  FeatureDecoder* decoder);

  // Returns the features (S x C) of a batch of latents (S x D). They are valid
  // until the next call. The MLP normalises with the statistics of the batch
  // and adds them to its running statistics. kInvalidArgument for a size that
  // is no multiple of D and, from the MLP, for latents that are not finite;
  // then the decoder is unchanged.
  StatusOr<std::span<const float>> Forward(std::span<const float> latents,
                                           ThreadPool& pool);

  // feature_gradients: dL/dfeatures for the batch of the last Forward(). Adds
  // dL/dlatents to `latent_gradients`, and collects dL/dparameters for the next
  // Step(). kInvalidArgument for sizes that do not fit the batch.
  Status Backward(std::span<const float> feature_gradients,
                  ThreadPool& pool,
                  std::span<float> latent_gradients);

  // One step of Adam over the parameters of the decoder, with the gradients
  // collected since the last step. kUnusableResult if a gradient is not finite
  // or exceeds 1e18; then the gradients are dropped and the decoder is
  // unchanged.
  Status Step(ThreadPool& pool);

  // The state of Adam, to continue training later. It is empty for a linear
  // decoder.
  const ArrayAdamState& adam() const { return adam_; }
  // kInvalidArgument for a state of another size.
  Status set_adam(ArrayAdamState state);

 private:
  DecoderTrainingOptions options_;
  FeatureDecoder* decoder_;
  MlpBatch batch_;
  std::vector<float> features_;   // S x C, of the last Forward.
  std::vector<float> gradients_;  // Gradients of the parameters.
  ArrayAdamState adam_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_DECODER_TRAINING_H_
